//! A plane through the origin of a bundle, held against the eight boxes of a node.

use intertri::internal::Frame;
use intertri::simd::Lanes;

use crate::tree::Node;

/// The padding of a plane, relative to the largest coordinate of origin and scene: 2^-18.
const PAD: f32 = 1.0 / (1 << 18) as f32;

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
    /// The plane of that normal through the origin of a frame, in a scene whose coordinates reach to ±`reach`.
    pub(crate) fn new(normal: [f32; 3], frame: &Frame, reach: f32) -> Self {
        let origin = frame.origin();
        let reach = origin.iter().fold(reach, |m, x| m.max(x.abs())) + frame.off() / PAD;
        let size = normal[0].abs() + normal[1].abs() + normal[2].abs();
        Self {
            normal,
            at: normal[0] * origin[0] + normal[1] * origin[1] + normal[2] * origin[2],
            pad: PAD * reach * size + f32::MIN_POSITIVE,
        }
    }

    /// The signed distances of those corners of eight boxes that are farthest along the normal; with
    /// `low`, least far.
    #[inline(always)]
    pub(crate) fn of_boxes<F: Lanes<Scalar = f32>>(&self, node: &Node, low: bool) -> F {
        let Self { normal, at, .. } = *self;
        let x = node.sides(0, (normal[0] > 0.0) != low);
        let y = node.sides(1, (normal[1] > 0.0) != low);
        let z = node.sides(2, (normal[2] > 0.0) != low);
        let sum = F::load(x).mul_add(F::splat(normal[0]), F::splat(-at));
        let sum = F::load(y).mul_add(F::splat(normal[1]), sum);
        F::load(z).mul_add(F::splat(normal[2]), sum)
    }
}
