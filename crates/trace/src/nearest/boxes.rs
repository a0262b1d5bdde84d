//! Computes lower bounds on the distances from a point to the eight boxes of a node or to the boxes
//! of eight triangles.

use intertri::simd::{Lanes, Vec3};

use crate::tree::Node;

/// The computed square of a distance exceeds the exact one by at most this fraction (`2^-20`).
const SHARE: f64 = 1.0 / (1_u64 << 20) as f64;

/// A bound on the absolute error that underflow, or treating subnormal numbers as 0, causes in a
/// squared distance (`2^-120`).
const TINY: f64 = f64::from_bits((1023 - 120) << 52);

/// Returns the largest value that [`squares`] may compute for a box containing a point whose
/// squared distance is below `most`.
#[inline(always)]
pub(super) fn far_for(most: f64) -> f32 {
    ((most * (1.0 + SHARE) + TINY) as f32).next_up()
}

/// Returns a mask of the boxes that may contain a point at a squared distance of at most `far` from
/// the query point, and the squared distance to each box. The two points of `within` enclose the
/// query point.
#[inline(always)]
pub(super) fn squares<F: Lanes<Scalar = f32>>(
    node: &Node,
    within: [Vec3<F>; 2],
    far: f32,
) -> (F::Mask, F) {
    // For a missing child, the lower sides exceed the upper sides.
    let lo = Vec3 {
        x: F::load(node.sides(0, false)),
        y: F::load(node.sides(1, false)),
        z: F::load(node.sides(2, false)),
    };
    let hi = Vec3 {
        x: F::load(node.sides(0, true)),
        y: F::load(node.sides(1, true)),
        z: F::load(node.sides(2, true)),
    };
    let square = to_boxes(lo, hi, within);
    (lo.x.le(hi.x) & square.le(F::splat(far)), square)
}

/// Returns a mask of the triangles whose bounding boxes may be within `far`.
#[inline(always)]
pub(super) fn may_be_near<F: Lanes<Scalar = f32>>(
    [a, b, c]: [Vec3<F>; 3],
    within: [Vec3<F>; 2],
    far: f32,
) -> F::Mask {
    let lo = Vec3 { x: a.x.min(b.x).min(c.x), y: a.y.min(b.y).min(c.y), z: a.z.min(b.z).min(c.z) };
    let hi = Vec3 { x: a.x.max(b.x).max(c.x), y: a.y.max(b.y).max(c.y), z: a.z.max(b.z).max(c.z) };
    to_boxes(lo, hi, within).le(F::splat(far))
}

/// Returns the squared distances from the query point to eight boxes.
#[inline(always)]
fn to_boxes<F: Lanes<Scalar = f32>>(lo: Vec3<F>, hi: Vec3<F>, [from, to]: [Vec3<F>; 2]) -> F {
    let none = F::splat(0.0);
    // The gap along each axis is the distance to the nearer side if the point is outside, or 0 if
    // the point is inside. `from` and `to` enclose the point.
    let (before, behind) = (lo - to, from - hi);
    let x = before.x.max(behind.x).max(none);
    let y = before.y.max(behind.y).max(none);
    let z = before.z.max(behind.z).max(none);
    z.mul_add(z, y.mul_add(y, x * x))
}
