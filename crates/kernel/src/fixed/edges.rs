//! The three edge determinants in i64 lanes, and their signs according to the tie rule.
//!
//! ```text
//!           C                A, B, C   the corners relative to the origin
//!          / \               h4 = B - A, h5 = C - A, n = h4 x h5, R = d x A
//!      h5 /   \
//!        /     \             V = d . (C x A) = -h5 . R
//!       A ----- B            W = d . (A x B) =  h4 . R
//!           h4               U = d . (B x C) =  d . n - V - W
//! ```

use super::numbers::round;
use crate::simd::{Ints, Lanes};

/// N integer vectors, one per lane.
pub(super) type V3<I> = [I; 3];

/// The determinants of N pairs of a ray and a triangle.
pub(super) struct Edges<I> {
    a: V3<I>,
    h4: V3<I>,
    h5: V3<I>,
    /// The determinant of the edge opposite the first corner.
    pub(super) u: I,
    /// The determinant of the edge opposite the second corner.
    pub(super) v: I,
    /// The determinant of the edge opposite the third corner.
    pub(super) w: I,
}

impl<I: Ints> Edges<I> {
    /// Computes the determinants of N pairs, where `n` is `h4 x h5`. Every product fits because
    /// `2 b + q <= 58`.
    #[inline(always)]
    pub(super) fn new(origin: V3<I>, d: V3<I>, [c1, h4, h5, n]: [V3<I>; 4]) -> Self {
        // The narrow factors: a, h4, and h5 have b + 2 bits and a sign bit; d has q + 1 bits and a
        // sign bit.
        let a = sub(c1, origin);
        let r = cross(d, a);
        // The wide factors: r and n.
        let v = I::splat(0) - I::dot(h5, r);
        let w = I::dot(h4, r);
        // The three determinants sum to d·n, so the third does not need a cross product.
        let u = I::dot(d, n) - v - w;
        Self { a, h4, h5, u, v, w }
    }

    /// Among the given lanes, finds those in which the ray's line crosses the triangle in the
    /// direction of the normal, and those in which it crosses against the normal. The ray's origin
    /// may be in the triangle's plane.
    #[inline(always)]
    pub(super) fn sides(&self, lanes: u32) -> (u32, u32) {
        let (nu, nv, nw) = (self.u.negative(), self.v.negative(), self.w.negative());
        let (zu, zv, zw) = (self.u.zero(), self.v.zero(), self.w.zero());

        // A zero rarely matters, because the signs of the other determinants usually decide.
        let open = !(nu | nv | nw) | ((nu | zu) & (nv | zv) & (nw | zw));
        if lanes & open & (zu | zv | zw) == 0 {
            return (lanes & !(nu | nv | nw), lanes & nu & nv & nw);
        }

        // The direction is moved by (e, e^2, e^3): the first nonzero component of B x C, C x A, or
        // A x B decides.
        let (b, c) = (add(self.a, self.h4), add(self.a, self.h5));
        let nu = nu | zu & first_sign_negative(cross(b, c));
        let nv = nv | zv & first_sign_negative(cross(c, self.a));
        let nw = nw | zw & first_sign_negative(cross(self.a, b));
        (lanes & !(nu | nv | nw), lanes & nu & nv & nw)
    }
}

/// Returns the lanes in which the first nonzero component is negative.
#[inline(always)]
pub(super) fn first_sign_negative<I: Ints>([x, y, z]: V3<I>) -> u32 {
    x.negative() | x.zero() & (y.negative() | y.zero() & z.negative())
}

/// Computes `A . (h4 x h5)`, the numerator of t, for one pair. The result has `3 b + 5` bits, which
/// may not fit in an i64.
#[inline(always)]
pub(super) fn volume(a: [i64; 3], h4: [i64; 3], h5: [i64; 3]) -> i128 {
    product(a, cross_i64(h4, h5))
}

/// Computes the dot product `a . n`, which may not fit in an i64.
#[inline(always)]
pub(super) fn product(a: [i64; 3], n: [i64; 3]) -> i128 {
    i128::from(a[0]) * i128::from(n[0])
        + i128::from(a[1]) * i128::from(n[1])
        + i128::from(a[2]) * i128::from(n[2])
}

/// Computes the cross product of two grid vectors.
#[inline(always)]
pub(super) fn cross_i64(a: [i64; 3], b: [i64; 3]) -> [i64; 3] {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

#[inline(always)]
pub(super) fn add<I: Ints>(a: V3<I>, b: V3<I>) -> V3<I> {
    [a[0] + b[0], a[1] + b[1], a[2] + b[2]]
}

#[inline(always)]
pub(super) fn sub<I: Ints>(a: V3<I>, b: V3<I>) -> V3<I> {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

/// Computes the cross product of vectors whose components fit in i32.
#[inline(always)]
pub(super) fn cross<I: Ints>(a: V3<I>, b: V3<I>) -> V3<I> {
    [
        a[1].mul_narrow(b[2]) - a[2].mul_narrow(b[1]),
        a[2].mul_narrow(b[0]) - a[0].mul_narrow(b[2]),
        a[0].mul_narrow(b[1]) - a[1].mul_narrow(b[0]),
    ]
}

// The functions below avoid `map`, because closures over registers are not always inlined, and a
// closure that is not inlined is compiled without the level's instructions.

/// Copies an integer vector to every lane.
#[inline(always)]
pub(super) fn splat<I: Ints>([x, y, z]: [i64; 3]) -> V3<I> {
    [I::splat(x), I::splat(y), I::splat(z)]
}

/// Loads N vectors whose f32 components are integers.
#[inline(always)]
pub(super) fn load<I: Ints, const N: usize>([x, y, z]: &[[f32; N]; 3]) -> V3<I> {
    [I::load_f32(x), I::load_f32(y), I::load_f32(z)]
}

/// Loads N f32 vectors.
#[inline(always)]
pub(super) fn load_f32<F: Lanes<Scalar = f32>, const N: usize>([x, y, z]: &[[f32; N]; 3]) -> V3<F> {
    [F::load(x), F::load(y), F::load(z)]
}

/// Copies an f32 vector to every lane.
#[inline(always)]
pub(super) fn splat_f32<F: Lanes<Scalar = f32>>([x, y, z]: [f32; 3]) -> V3<F> {
    [F::splat(x), F::splat(y), F::splat(z)]
}

/// Converts a grid vector to i64.
#[inline(always)]
pub(super) fn i64s([x, y, z]: [i32; 3]) -> [i64; 3] {
    [i64::from(x), i64::from(y), i64::from(z)]
}

/// Converts f32 components that are exact integers to a grid vector. Rounding is cheaper than a
/// cast, which has to handle out-of-range values.
#[inline(always)]
pub(super) fn i32s([x, y, z]: [f32; 3]) -> [i32; 3] {
    [round(x.into()) as i32, round(y.into()) as i32, round(z.into()) as i32]
}

/// Converts a grid vector to f32 exactly.
#[inline(always)]
pub(super) fn f32s([x, y, z]: [i32; 3]) -> [f32; 3] {
    [x as f32, y as f32, z as f32]
}
