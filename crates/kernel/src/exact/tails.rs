//! Computes correctly rounded t, u, and v for f64 input. The method is the same as in
//! [`rounded`](super::rounded), except that each difference of coordinates has two parts.
//!
//! ```text
//!   A = a + a'    h4 = h + h'    h5 = k + k'        Each difference is exact, in two parts.
//!   n = h × k  in two parts,  plus  h × k' + h' × k  in one part
//! ```
//!
//! `docs/numerics/f64.md`, section 3, has the bounds and the proof.

use super::double::{Double, cross, dot, sum};
use super::rounded::{Volume, quotient};
use crate::simd::{Lanes, Vec3};

/// `2^-97`, which is `512w²`, where w is half an ulp of 1. The error of a volume is at most a sixth
/// of this value times the volume's permanent. Division adds an error of at most a twentieth of
/// this value times the quotient's magnitude.
pub(super) const DOUBT: f64 = 1.0 / (1_u128 << 97) as f64;

/// A quotient can be proven to be correctly rounded only if it is 0 or its magnitude is between
/// these limits, `2^±500`.
const TAME: [f64; 2] = [f64::from_bits((1023 - 500) << 52), f64::from_bits((1023 + 500) << 52)];

/// A vector in two parts.
#[derive(Clone, Copy)]
pub(super) struct TwoParts<D> {
    pub(super) first: Vec3<D>,
    pub(super) rest: Vec3<D>,
}

/// Computes `a - b` exactly.
#[inline(always)]
pub(super) fn difference<D: Lanes<Scalar = f64>>(a: Vec3<D>, b: Vec3<D>) -> TwoParts<D> {
    let (x, y, z) = (sum(a.x, -b.x), sum(a.y, -b.y), sum(a.z, -b.z));
    let first = Vec3 { x: x.high, y: y.high, z: z.high };
    TwoParts { first, rest: Vec3 { x: x.low, y: y.low, z: z.low } }
}

/// Adds a small remainder to a number in two parts.
#[inline(always)]
fn more<D: Lanes<Scalar = f64>>(x: &Double<D>, rest: D) -> Double<D> {
    sum(x.high, x.low + rest)
}

/// Adds the contribution of the factors' second parts to a cross product.
#[inline(always)]
fn with_rest<D: Lanes<Scalar = f64>>([x, y, z]: &[Double<D>; 3], rest: Vec3<D>) -> [Double<D>; 3] {
    [more(x, rest.x), more(y, rest.y), more(z, rest.z)]
}

/// Computes the cross product of two vectors that have two parts each.
#[inline(always)]
pub(super) fn cross_tails<D: Lanes<Scalar = f64>>(
    a: &TwoParts<D>,
    b: &TwoParts<D>,
) -> [Double<D>; 3] {
    // `a.rest × b.rest` is omitted. Each of its components is smaller than w² times the sum of the
    // magnitudes of the first parts' products, and the error bound covers it (f64.md, section 3).
    let rest = a.first.cross_fused(b.rest) + a.rest.cross_fused(b.first);
    with_rest(&cross(a.first, b.first), rest)
}

/// Computes the dot product of a cross product and a vector, both in two parts.
#[inline(always)]
pub(super) fn times<D: Lanes<Scalar = f64>>(
    product: &[Double<D>; 3],
    by: &TwoParts<D>,
) -> Double<D> {
    let [x, y, z] = product;
    let first = Vec3 { x: x.high, y: y.high, z: z.high };
    // The product of the two second parts is omitted; the error bound covers it.
    more(&dot(product, by.first), first.dot_fused(by.rest))
}

/// Returns the lanes in which a quotient is 0 or far from the limits of f64's exponent range.
#[inline(always)]
pub(super) fn is_tame_quotient<D: Lanes<Scalar = f64>>(q: D) -> D::Mask {
    // Nearer to the limits, intermediate results on which the proof relies could be subnormal. A
    // quotient of 0 does not need this check.
    let size = q.abs();
    let tame = size.ge(D::splat(TAME[0])) & size.le(D::splat(TAME[1]));
    tame | size.le(D::splat(0.0))
}

/// A ray and a triangle in each lane. No coordinate may be near the limits of f64's exponent range.
#[derive(Clone, Copy)]
pub(super) struct SeenTails<D: Lanes> {
    a: TwoParts<D>,
    h4: TwoParts<D>,
    h5: TwoParts<D>,
    dir: Vec3<D>,
    normal: [Double<D>; 3],
    den: Volume<D>,
    inverse: D,
}

impl<D: Lanes<Scalar = f64>> SeenTails<D> {
    #[inline(always)]
    pub(super) fn new([c1, c2, c3]: [Vec3<D>; 3], org: Vec3<D>, dir: Vec3<D>) -> Self {
        let (a, h4, h5) = (difference(c1, org), difference(c2, c1), difference(c3, c1));
        let normal = cross_tails(&h4, &h5);
        let den = Volume {
            value: dot(&normal, dir),
            // The permanent of the first parts can replace the permanent of the exact differences,
            // because each difference changes it by a factor of at most 1 + w.
            err: permanent(h4.first, h5.first, dir) * D::splat(DOUBT),
        };
        Self { a, h4, h5, dir, normal, den, inverse: D::splat(1.0) / den.value.high }
    }

    /// Returns t and the lanes in which it is proven to be correctly rounded.
    #[inline(always)]
    pub(super) fn t(&self) -> (D, D::Mask) {
        let Self { a, h4, h5, normal, .. } = self;
        self.over(normal, a, permanent(h4.first, h5.first, a.first))
    }

    /// Returns u and v, the weights of the second and third corners, and the lanes in which both
    /// are proven to be correctly rounded.
    #[inline(always)]
    pub(super) fn weights(&self) -> (D, D, D::Mask) {
        let Self { a, h4, h5, dir, .. } = self;
        // u and v share the ray's moment A × d: u is h5·(A × d) / D, v is -h4·(A × d) / D.
        let moment = with_rest(&cross(a.first, *dir), a.rest.cross_fused(*dir));
        let minus_h4 = TwoParts { first: minus(h4.first), rest: minus(h4.rest) };
        let (u, u_sure) = self.over(&moment, h5, permanent(a.first, *dir, h5.first));
        let (v, v_sure) = self.over(&moment, &minus_h4, permanent(a.first, *dir, h4.first));
        (u, v, u_sure & v_sure)
    }

    /// Divides the dot product of a cross product and a vector by D.
    #[inline(always)]
    fn over(&self, product: &[Double<D>; 3], by: &TwoParts<D>, permanent: D) -> (D, D::Mask) {
        let num = Volume { value: times(product, by), err: permanent * D::splat(DOUBT) };
        let (q, sure) = quotient(&num, &self.den, self.inverse);
        (q, sure & is_tame_quotient(q))
    }
}

#[inline(always)]
fn minus<D: Lanes>(v: Vec3<D>) -> Vec3<D> {
    Vec3 { x: -v.x, y: -v.y, z: -v.z }
}

/// Returns the permanent of `x·(y × z)`: the sum of the magnitudes of its products.
#[inline(always)]
fn permanent<D: Lanes<Scalar = f64>>(y: Vec3<D>, z: Vec3<D>, x: Vec3<D>) -> D {
    y.abs().permanents(z.abs()).dot_fused(x.abs())
}
