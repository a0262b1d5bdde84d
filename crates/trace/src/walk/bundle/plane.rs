//! A plane next to the rays of a bundle, tested against the eight boxes of a node.

use intertri::internal::Frame;
use intertri::simd::Lanes;

use crate::tree::{Margin, Node};

/// The padding of a plane, as a fraction of the origin's largest coordinate: 10u. Other rounding
/// errors are proportional to the distance, and callers account for them.
const PAD: f32 = 10.0 / (1 << 24) as f32;

/// A plane, given by its normal.
#[derive(Clone, Copy, Debug)]
pub(crate) struct CullingPlane {
    normal: [f32; 3],
    /// The dot product of the normal and a point of the plane.
    at: f32,
    /// A bound on the rounding error of a distance from the plane.
    pub(crate) pad: f32,
}

impl CullingPlane {
    /// Creates the plane with the given normal through the origin of a frame.
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

    /// Moves the plane by a signed distance along its normal, in units of the normal, for distances
    /// whose error is larger by up to `pad`.
    pub(crate) fn moved(self, by: f32, pad: f32) -> Self {
        Self { at: self.at + by, pad: self.pad + pad, ..self }
    }

    /// Returns the sum of the magnitudes of the normal's components.
    pub(crate) fn size(&self) -> f32 {
        size(self.normal)
    }

    /// Adds a margin for comparing distances with `limit`. The margin covers the rounding errors for
    /// points that are at most `distance` away from the origin along each axis.
    pub(crate) fn for_places_within(self, distance: f32, limit: f32) -> Self {
        let pad = self.pad + PAD * (distance * size(self.normal) + limit.abs());
        Self { pad, ..self }
    }

    /// Returns, for each of eight boxes, the signed distance of the corner farthest along the
    /// normal or, if `low` is set, of the opposite corner.
    #[inline(always)]
    pub(crate) fn of_boxes<F: Lanes<Scalar = f32>>(&self, node: &Node, low: bool) -> F {
        let Self { normal, at, .. } = *self;
        // The signs of the normal determine which corner is lowest or highest along it; they are
        // the same for all eight boxes.
        let x = node.sides(0, (normal[0] > 0.0) != low);
        let y = node.sides(1, (normal[1] > 0.0) != low);
        let z = node.sides(2, (normal[2] > 0.0) != low);
        let sum = F::load(x).mul_add(F::splat(normal[0]), F::splat(-at));
        let sum = F::load(y).mul_add(F::splat(normal[1]), sum);
        F::load(z).mul_add(F::splat(normal[2]), sum)
    }
}

/// Returns the sum of the magnitudes of a vector's components.
fn size(v: [f32; 3]) -> f32 {
    v[0].abs() + v[1].abs() + v[2].abs()
}
