//! A plane through the origin of a bundle, tested against the eight boxes of a node.

use intertri::internal::Frame;
use intertri::simd::Lanes;

use crate::tree::{Margin, Node};

/// The padding of a plane, relative to the largest coordinate of the origin: 10u. What rounding takes from the rest of
/// a distance is a share of it, for which those who compare have room.
const PAD: f32 = 10.0 / (1 << 24) as f32;

/// A plane through the origin, by the side to which it looks.
#[derive(Clone, Copy, Debug)]
pub(crate) struct CullingPlane {
    normal: [f32; 3],
    /// `normal · origin`
    at: f32,
    /// What rounding can take.
    pub(crate) pad: f32,
}

impl CullingPlane {
    /// The plane of that normal through the origin of a frame, in a tree.
    pub(crate) fn new(normal: [f32; 3], frame: &Frame, margin: &Margin) -> Self {
        let origin = frame.origin();
        let away = origin.iter().fold(0.0, |m: f32, x| m.max(x.abs()));
        let room = PAD * away + margin.room(away) + frame.off();
        Self {
            normal,
            at: normal[0] * origin[0] + normal[1] * origin[1] + normal[2] * origin[2],
            pad: room * size(normal) + f32::MIN_POSITIVE,
        }
    }

    /// The same plane with room for what rounding takes from the distances of places that are not farther from the
    /// origin along any axis, beside 1.
    pub(crate) fn for_places_within(self, distance: f32) -> Self {
        let pad = self.pad + PAD * (distance * size(self.normal) + 1.0);
        Self { pad, ..self }
    }

    /// The signed distances of those corners of eight boxes that are farthest along the normal; with
    /// `low`, least far.
    #[inline(always)]
    pub(crate) fn of_boxes<F: Lanes<Scalar = f32>>(&self, node: &Node, low: bool) -> F {
        let Self { normal, at, .. } = *self;
        // The corner that is lowest or highest along the normal is chosen by the normal's signs, for all eight boxes
        // alike.
        let x = node.sides(0, (normal[0] > 0.0) != low);
        let y = node.sides(1, (normal[1] > 0.0) != low);
        let z = node.sides(2, (normal[2] > 0.0) != low);
        let sum = F::load(x).mul_add(F::splat(normal[0]), F::splat(-at));
        let sum = F::load(y).mul_add(F::splat(normal[1]), sum);
        F::load(z).mul_add(F::splat(normal[2]), sum)
    }
}

/// The sum of a vector's sizes.
fn size(v: [f32; 3]) -> f32 {
    v[0].abs() + v[1].abs() + v[2].abs()
}
