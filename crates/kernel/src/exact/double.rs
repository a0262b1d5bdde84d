//! Two-part numbers (double-double arithmetic): sums and products of f64 values, with twice the
//! precision of f64.
//!
//! Dekker, A Floating-Point Technique for Extending the Available Precision, 1971; Knuth, The Art
//! of Computer Programming, volume 2, section 4.2.2.

use crate::simd::{Lanes, Vec3};

/// The number `high + low`, where low is about `2^-52` times the products that make up the number.
#[derive(Clone, Copy)]
pub(super) struct Double<D> {
    pub(super) high: D,
    pub(super) low: D,
}

/// Returns the exact sum of two numbers.
#[inline(always)]
pub(super) fn sum<D: Lanes>(a: D, b: D) -> Double<D> {
    let high = a + b;
    // This is Knuth's TwoSum, in which the order of the two magnitudes does not matter.
    let of_b = high - a;
    Double { high, low: (a - (high - of_b)) + (b - of_b) }
}

/// Returns the exact sum of two numbers, if the second is not larger in magnitude.
#[inline(always)]
pub(super) fn short_sum<D: Lanes>(a: D, b: D) -> Double<D> {
    let high = a + b;
    // This is Dekker's Fast2Sum, which needs three operations instead of six if the order of
    // magnitudes is known.
    Double { high, low: b - (high - a) }
}

/// Returns the exact product of two numbers.
#[inline(always)]
pub(super) fn product<D: Lanes>(a: D, b: D) -> Double<D> {
    let high = a * b;
    Double { high, low: a.mul_error(b, high) }
}

/// Returns `a b - c d`, with an error of at most `3w²` times `|a b| + |c d|`, where w is half an
/// ulp of 1.
#[inline(always)]
fn minor<D: Lanes>(a: D, b: D, c: D, d: D) -> Double<D> {
    let (p, q) = (product(a, b), product(c, d));
    let difference = sum(p.high, -q.high);
    Double { high: difference.high, low: difference.low + (p.low - q.low) }
}

/// Returns the cross product of two vectors, in two-part numbers.
#[inline(always)]
pub(super) fn cross<D: Lanes>(a: Vec3<D>, b: Vec3<D>) -> [Double<D>; 3] {
    [minor(a.y, b.z, a.z, b.y), minor(a.z, b.x, a.x, b.z), minor(a.x, b.y, a.y, b.x)]
}

/// Returns the dot product of a cross product in two-part numbers and a vector, with an error of at
/// most `40w²` times the permanent.
#[inline(always)]
pub(super) fn dot<D: Lanes>([x, y, z]: &[Double<D>; 3], v: Vec3<D>) -> Double<D> {
    let (px, py, pz) = (product(x.high, v.x), product(y.high, v.y), product(z.high, v.z));
    let xy = sum(px.high, py.high);
    let all = sum(xy.high, pz.high);
    // All high parts are summed exactly. The low parts are at most `w` times as large, so they may
    // be summed with rounding.
    let low = (xy.low + all.low) + ((px.low + py.low) + pz.low);
    let lows = Vec3 { x: x.low, y: y.low, z: z.low };
    sum(all.high, lows.dot_add(v, low))
}

/// Returns the high and low parts of a vector.
#[inline(always)]
pub(super) fn parts<D: Lanes>([x, y, z]: &[Double<D>; 3]) -> [Vec3<D>; 2] {
    [Vec3 { x: x.high, y: y.high, z: z.high }, Vec3 { x: x.low, y: y.low, z: z.low }]
}

/// Returns the vector with these high and low parts.
#[inline(always)]
pub(super) fn whole<D: Lanes>([high, low]: [Vec3<D>; 2]) -> [Double<D>; 3] {
    [
        Double { high: high.x, low: low.x },
        Double { high: high.y, low: low.y },
        Double { high: high.z, low: low.z },
    ]
}

/// Returns `a - b` and the sum of the magnitudes of its rounding errors.
#[inline(always)]
pub(super) fn difference<D: Lanes>(a: Vec3<D>, b: Vec3<D>) -> (Vec3<D>, D) {
    let (x, y, z) = (sum(a.x, -b.x), sum(a.y, -b.y), sum(a.z, -b.z));
    let rest = x.low.abs() + y.low.abs() + z.low.abs();
    (Vec3 { x: x.high, y: y.high, z: z.high }, rest)
}
