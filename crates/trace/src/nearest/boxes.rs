//! How far a point is from the eight boxes of a node, from below.

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

/// Which boxes may hold something whose square is at most what `far` is for, and their squares.
#[inline(always)]
pub(super) fn squares<F: Lanes<Scalar = f32>>(
    node: &Node,
    point: Vec3<F>,
    far: f32,
) -> (F::Mask, F) {
    // A child that is not there has nothing between its sides.
    let (x, is_there) = gap(node, 0, point.x);
    let ((y, _), (z, _)) = (gap(node, 1, point.y), gap(node, 2, point.z));
    let square = z.mul_add(z, y.mul_add(y, x * x));
    (is_there & square.le(F::splat(far)), square)
}

/// How far outside of the boxes along an axis, and where there is a box.
#[inline(always)]
fn gap<F: Lanes<Scalar = f32>>(node: &Node, axis: usize, at: F) -> (F, F::Mask) {
    let (lo, hi) = (F::load(node.sides(axis, false)), F::load(node.sides(axis, true)));
    ((lo - at).max(at - hi).max(F::splat(0.0)), lo.le(hi))
}
