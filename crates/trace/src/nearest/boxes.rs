//! How far a point is from the eight boxes of a node, or from those of eight triangles: from below.

use intertri::simd::{Lanes, Vec3};

use crate::tree::Node;

/// Squares are within this of themselves, upwards: `2^-20`.
const SHARE: f64 = 1.0 / (1_u64 << 20) as f64;

/// What underflow and subnormal numbers that are read as 0 can make of a square: `2^-120`.
const TINY: f64 = f64::from_bits((1023 - 120) << 52);

/// The largest square, as [`squares`] has it, of a box that may hold something nearer than the root of `most`.
#[inline(always)]
pub(super) fn far_for(most: f64) -> f32 {
    ((most * (1.0 + SHARE) + TINY) as f32).next_up()
}

/// Which boxes may hold something whose square is at most what `far` is for, and their squares; the point lies
/// between two.
#[inline(always)]
pub(super) fn squares<F: Lanes<Scalar = f32>>(
    node: &Node,
    within: [Vec3<F>; 2],
    far: f32,
) -> (F::Mask, F) {
    // A child that is not there has nothing between its sides.
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

/// Which of eight triangles may be nearer than what `far` is for, by the boxes around them.
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

/// The squares of the distances to boxes.
#[inline(always)]
fn to_boxes<F: Lanes<Scalar = f32>>(lo: Vec3<F>, hi: Vec3<F>, [from, to]: [Vec3<F>; 2]) -> F {
    let none = F::splat(0.0);
    let (before, behind) = (lo - to, from - hi);
    let x = before.x.max(behind.x).max(none);
    let y = before.y.max(behind.y).max(none);
    let z = before.z.max(behind.z).max(none);
    z.mul_add(z, y.mul_add(y, x * x))
}
