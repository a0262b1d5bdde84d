//! t, u and v, each the exact value rounded once: numbers of twice the digits in lanes, with a proof of
//! the rounding.
//!
//! ```text
//!        ...●─────────────┼─────────────●───────────      f64 and half-way: where all that the
//!          f64    [══╪══] half         f64                quotient may be rounds alike, so does it
//! ```
//!
//! Bounds and proof: `docs/numerics/exact.md`, section 6.

use super::double::{Double, cross, difference, dot};
use crate::simd::{Lanes, Vec3};

/// `2^-99`, which is `128w²`: a volume of twice the digits is within half of this times its permanent, and
/// a quotient by it within half of this of itself besides.
pub(super) const DOUBT: f64 = 1.0 / (1_u128 << 99) as f64;

/// A ray and a triangle in each lane, in numbers that f64 holds exactly.
#[derive(Clone, Copy)]
pub struct Seen<D: Lanes> {
    a: Vec3<D>,
    h4: Vec3<D>,
    h5: Vec3<D>,
    dir: Vec3<D>,
    /// Where f64 holds them.
    exact: D::Mask,
    den: Volume<D>,
    inverse: D,
    normal: [Double<D>; 3],
}

/// A number of twice the digits, and what it may be off by.
#[derive(Clone, Copy)]
pub(super) struct Volume<D> {
    pub(super) value: Double<D>,
    pub(super) err: D,
}

impl<D: Lanes<Scalar = f64>> Volume<D> {
    /// `x·(y × z)`, where the cross product is given, too.
    #[inline(always)]
    fn new(x: Vec3<D>, product: &[Double<D>; 3], y: Vec3<D>, z: Vec3<D>) -> Self {
        let permanent = y.abs().permanents(z.abs()).dot_fused(x.abs());
        Self { value: dot(product, x), err: permanent * D::splat(DOUBT) }
    }
}

impl<D: Lanes<Scalar = f64>> Seen<D> {
    /// Corners, origins and directions in lanes, none of which may be subnormal in f32.
    #[inline(always)]
    pub fn new([c1, c2, c3]: [Vec3<D>; 3], org: Vec3<D>, dir: Vec3<D>) -> Self {
        let ((a, x), (h4, y), (h5, z)) =
            (difference(c1, org), difference(c2, c1), difference(c3, c1));
        let normal = cross(h4, h5);
        let den = Volume::new(dir, &normal, h4, h5);
        let inverse = D::splat(1.0) / den.value.high;
        let exact = (x + y + z).le(D::splat(0.0));
        Self { a, h4, h5, dir, exact, den, inverse, normal }
    }

    /// t, and where it is proven to be rounded right.
    #[inline(always)]
    pub fn t(&self) -> (D, D::Mask) {
        self.over(&Volume::new(self.a, &self.normal, self.h4, self.h5))
    }

    /// u and v, the weights of the second and the third corner, and where both are proven.
    #[inline(always)]
    pub fn weights(&self) -> (D, D, D::Mask) {
        let (a, dir) = (self.a, self.dir);
        let moment = cross(a, dir);
        let minus_h4 = Vec3 { x: -self.h4.x, y: -self.h4.y, z: -self.h4.z };
        let (u, u_sure) = self.over(&Volume::new(self.h5, &moment, a, dir));
        let (v, v_sure) = self.over(&Volume::new(minus_h4, &moment, a, dir));
        (u, v, u_sure & v_sure)
    }

    /// A quotient by D.
    #[inline(always)]
    fn over(&self, num: &Volume<D>) -> (D, D::Mask) {
        let (q, sure) = quotient(num, &self.den, self.inverse);
        (q, self.exact & sure)
    }
}

/// The quotient of two volumes, and where it is proven to be rounded right; `inverse` is that of the
/// denominator's high part. Twice what the denominator may be off by is told.
#[inline(always)]
pub(super) fn quotient<D: Lanes<Scalar = f64>>(
    num: &Volume<D>,
    den: &Volume<D>,
    inverse: D,
) -> (D, D::Mask) {
    let Volume { value: den, err: den_err } = *den;
    let Volume { value: num, err: num_err } = *num;
    let q = num.high * inverse;

    // What it lacks: num - q den, which cancels, over den.
    let p = q * den.high;
    let lacks = ((num.high - p) - q.mul_error(den.high, p)) + (num.low - q * den.low);
    let rest = lacks * inverse;

    // Roundings keep the order: where both ends of what it may be round alike, so does it.
    let doubt = q.abs().mul_add(den_err, num_err) * inverse.abs();
    let (least, most) = (q + (rest - doubt), q + (rest + doubt));
    // No zero has a sign.
    (most + D::splat(0.0), most.le(least))
}
