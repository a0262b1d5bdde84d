//! Computes correctly rounded t, u, and v with double-double arithmetic in lanes. An error bound
//! proves that the results are correctly rounded.
//!
//! ```text
//!        ...●─────────────┼─────────────●───────────      f64 and halfway points. If both ends of
//!          f64    [══╪══] half         f64                the error interval round alike, so does
//!                                                         the quotient.
//! ```
//!
//! `docs/numerics/exact.md`, section 6, has the bounds and the proof.

use super::double::{Double, cross, difference, dot};
use crate::simd::{Lanes, Vec3};

/// `2^-99`, which is `128w²`, where w is half an ulp of 1. The error of a double-double volume is
/// at most half this value times the volume's permanent. Division adds an error of at most half
/// this value times the quotient's magnitude.
pub(super) const DOUBT: f64 = 1.0 / (1_u128 << 99) as f64;

/// A ray and a triangle in each lane, with coordinates that are exact in f64.
#[derive(Clone, Copy)]
pub struct Quotients<D: Lanes> {
    a: Vec3<D>,
    h4: Vec3<D>,
    h5: Vec3<D>,
    dir: Vec3<D>,
    /// The lanes in which the differences of coordinates are exact.
    exact: D::Mask,
    den: Volume<D>,
    inverse: D,
    normal: [Double<D>; 3],
}

/// A double-double number and its error bound.
#[derive(Clone, Copy)]
pub(super) struct Volume<D> {
    pub(super) value: Double<D>,
    pub(super) err: D,
}

impl<D: Lanes<Scalar = f64>> Volume<D> {
    /// Computes `x·(y × z)`, where `product` is the cross product `y × z`.
    #[inline(always)]
    pub(super) fn new(x: Vec3<D>, product: &[Double<D>; 3], y: Vec3<D>, z: Vec3<D>) -> Self {
        let permanent = y.abs().permanents(z.abs()).dot_fused(x.abs());
        Self { value: dot(product, x), err: permanent * D::splat(DOUBT) }
    }
}

impl<D: Lanes<Scalar = f64>> Quotients<D> {
    /// Prepares the quotients of a ray and a triangle in each lane. If an f32 coordinate was subnormal,
    /// the CPU must not have read it as 0.
    #[inline(always)]
    pub fn new([c1, c2, c3]: [Vec3<D>; 3], org: Vec3<D>, dir: Vec3<D>) -> Self {
        let ((a, x), (h4, y), (h5, z)) =
            (difference(c1, org), difference(c2, c1), difference(c3, c1));
        let normal = cross(h4, h5);
        let den = Volume::new(dir, &normal, h4, h5);
        let inverse = D::splat(1.0) / den.value.high;
        // The error bound does not cover differences that are inexact in f64.
        let exact = (x + y + z).le(D::splat(0.0));
        Self { a, h4, h5, dir, exact, den, inverse, normal }
    }

    /// Returns t and the lanes in which it is proven to be correctly rounded.
    #[inline(always)]
    pub fn t(&self) -> (D, D::Mask) {
        self.over(&Volume::new(self.a, &self.normal, self.h4, self.h5))
    }

    /// Returns u and v, the weights of the second and third corners, and the lanes in which both
    /// are proven to be correctly rounded.
    #[inline(always)]
    pub fn weights(&self) -> (D, D, D::Mask) {
        let (a, dir) = (self.a, self.dir);
        // u and v share the ray's moment A × d: u is h5·(A × d) / D, v is -h4·(A × d) / D.
        let moment = cross(a, dir);
        let minus_h4 = Vec3 { x: -self.h4.x, y: -self.h4.y, z: -self.h4.z };
        let (u, u_sure) = self.over(&Volume::new(self.h5, &moment, a, dir));
        let (v, v_sure) = self.over(&Volume::new(minus_h4, &moment, a, dir));
        (u, v, u_sure & v_sure)
    }

    /// Divides a volume by D.
    #[inline(always)]
    fn over(&self, num: &Volume<D>) -> (D, D::Mask) {
        let (q, sure) = quotient(num, &self.den, self.inverse);
        (q, self.exact & sure)
    }
}

/// Returns the quotient of two volumes and the lanes in which it is proven to be correctly rounded.
/// `inverse` is the reciprocal of the denominator's high part. The `err` passed for the denominator
/// is twice its error bound.
#[inline(always)]
pub(super) fn quotient<D: Lanes<Scalar = f64>>(
    num: &Volume<D>,
    den: &Volume<D>,
    inverse: D,
) -> (D, D::Mask) {
    let Volume { value: den, err: den_err } = *den;
    let Volume { value: num, err: num_err } = *num;
    let q = num.high * inverse;

    // The remainder num - q den, in which the leading digits cancel, divided by den.
    let p = q * den.high;
    let lacks = ((num.high - p) - q.mul_error(den.high, p)) + (num.low - q * den.low);
    let rest = lacks * inverse;

    // Rounding preserves order: if both ends of the error interval round to the same number, so
    // does the quotient.
    let doubt = q.abs().mul_add(den_err, num_err) * inverse.abs();
    let (least, most) = (q + (rest - doubt), q + (rest + doubt));
    // Turn negative zeros into positive zeros.
    (most + D::splat(0.0), most.le(least))
}

#[cfg(test)]
mod tests {
    use core::cmp::Ordering;

    use super::super::int::{self, Int};
    use super::super::quotient::Quotient;
    use super::super::scale::Dyadic;
    use super::*;

    /// A deterministic random number generator.
    struct Numbers(u64);

    impl Numbers {
        /// Returns a random integer below `2^bits`.
        fn below(&mut self, bits: u32) -> i64 {
            self.0 = self.0.wrapping_mul(0x5851_f42d_4c95_7f2d).wrapping_add(0x1405_7b7e_f767_814f);
            ((self.0 ^ self.0 >> 31).wrapping_mul(0x9e37_79b9_7f4a_7c15) >> (64 - bits)) as i64
        }

        fn vector(&mut self) -> [i64; 3] {
            [(); 3].map(|()| (self.below(53) | 1 << 52) * (1 - 2 * self.below(1)))
        }
    }

    /// Converts an f64 with an integer value to an integer.
    fn whole(x: f64) -> Int<3> {
        let (exponent, fraction) = (x.abs().to_bits() >> 52, x.to_bits() & ((1 << 52) - 1));
        let m = (fraction | 1 << 52) as i64;
        match exponent as i32 - 1075 {
            -1075 => Int([0; 3]),
            e if e < 0 => Int::new((m >> -e) * x.signum() as i64, 0),
            e => Int::new(m * x.signum() as i64, e as u32),
        }
    }

    /// Returns the approximate magnitude of an integer.
    fn near(x: Int<3>) -> f64 {
        let [a, b, c] = x.size().map(|limb| limb as f64);
        a + (b + c * 2.0_f64.powi(64)) * 2.0_f64.powi(64)
    }

    /// Returns the error of a double-double volume as a multiple of `w²` times the volume's
    /// permanent.
    fn share(x: [i64; 3], y: [i64; 3], z: [i64; 3]) -> f64 {
        let lanes = |v: [i64; 3]| Vec3::<f64>::splat(v.map(|x| x as f64));
        let exact = {
            let ints = |v: [i64; 3]| v.map(|x| Int::<1>::new(x, 0));
            int::dot::<1, 2, 3>(&ints(x), &int::cross(&ints(y), &ints(z)))
        };
        let (x, y, z) = (lanes(x), lanes(y), lanes(z));
        let Volume { value, err } = Volume::new(x, &cross(y, z), y, z);
        let off = near(whole(value.high) + whole(value.low) - exact);
        off * 128.0 / err
    }

    #[test]
    fn volumes_are_within_their_bound() {
        let (mut numbers, mut most) = (Numbers(1), 0.0_f64);
        for _ in 0..300 {
            // Hill climbing: keep every change that does not decrease the error.
            let mut all = [(); 3].map(|()| numbers.vector());
            let mut used = 0.0;
            for _ in 0..400 {
                let before = all;
                let number =
                    &mut all[numbers.below(20) as usize % 3][numbers.below(20) as usize % 3];
                *number ^= numbers.below(52);
                let now = share(all[0], all[1], all[2]);
                if now < used {
                    all = before;
                } else {
                    used = now;
                }
            }
            most = most.max(used);
        }
        assert!(1.5 < most && most < 27.0, "{most}");
    }

    /// Tests quotients near the midpoint of two f64 values, where the last digits decide the
    /// rounding.
    #[test]
    fn a_sure_quotient_is_rounded_right() {
        let (mut numbers, mut sure_ones) = (Numbers(2), 0);
        for i in 0..200_000 {
            let den = numbers.below(52) | 1 << 51;
            let middle = i128::from(numbers.below(53) | 1 << 53) * 2 + i128::from(i % 2);
            let num = middle * i128::from(den) + i128::from(numbers.below(2 + i % 50) - 1);
            let seen = Quotients::new([0, 1, 2].map(axis), axis(3), axis(2));
            let value = |x: i128| {
                let high = x as f64;
                Double { high, low: (x - high as i128) as f64 }
            };
            let (num_two, den_two) = (value(num), value(den.into()));
            let seen = Quotients {
                den: Volume { value: den_two, err: den_two.high * DOUBT },
                inverse: 1.0 / den_two.high,
                ..seen
            };
            let (q, sure) = seen.over(&Volume { value: num_two, err: 0.0 });
            let limbs = [num as u64, (num >> 64) as u64, 0];
            let exact = Quotient::new(&limbs, &[den as u64, 0, 0], 0);
            if sure {
                sure_ones += 1;
                assert_eq!(q, exact.to_f64(), "{num} / {den}");
            }
            assert_eq!(exact.cmp_number(Dyadic::of(f32::MAX)), Ordering::Less);
        }
        assert!(sure_ones > 100_000, "{sure_ones}");
    }

    /// Returns the unit vector along an axis, or the zero vector if `k` is not an axis.
    fn axis(k: usize) -> Vec3<f64> {
        Vec3::splat([0, 1, 2].map(|i| f64::from(u8::from(i == k))))
    }
}
