//! The correctly rounded f64 quotient of two integers that f64 may be unable to represent exactly.
//!
//! ```text
//!   q ≈ num / den     p = q den ──► rest = (num - p) / den ──► q + rest
//!                                                                │
//!                        ...●─────────────┼─────────────●─────── ▼
//!                           f64         half           f64    not too near the halfway point?
//! ```
//!
//! `docs/fixed-point.md` has the derivation.

use crate::simd::Lanes;

/// A number in two parts: the nearest f64 and the remainder.
pub(super) type Parts<F> = [F; 2];

/// Returns the exact sum of two numbers in two parts. The larger number must be a multiple of the
/// smaller number's unit in the last place, which always holds for integers.
#[inline(always)]
pub(super) fn sum<F: Lanes<Scalar = f64>>(high: F, low: F) -> Parts<F> {
    let sum = high + low;
    [sum, (high - sum) + low]
}

/// Returns `num / den`, rounded to the nearest f64, ties to even, and the lanes in which the
/// rounding is certain: all except those in which the quotient is a tie or extremely close to one.
/// The integers must be below `2^67`.
#[inline(always)]
pub(super) fn quotient<F: Lanes<Scalar = f64>>(num: Parts<F>, den: Parts<F>) -> (F, F::Mask) {
    // Four roundings contribute to the error of the estimate q.
    let inverse = F::splat(1.0) / den[0];
    let q = num[0] * inverse;

    // The remainder num - q den, in which the leading digits cancel, divided by den.
    let p = q * den[0];
    let lacks = ((num[0] - p) - q.mul_error(den[0], p)) + (num[1] - q * den[1]);
    let [q, rest] = sum(q, lacks * inverse);

    // Rounding preserves order: if both ends of the error interval round to the same number, so
    // does the quotient.
    let doubt = q.abs() * F::splat(DOUBT);
    (q, (q + (rest + doubt)).le(q) & (q + (rest - doubt)).ge(q))
}

/// `2^-96`, a safe bound: the relative error of the quotient in two parts is less than `2^-100`.
const DOUBT: f64 = 1.0 / (1_u128 << 96) as f64;

/// Splits a number below `2^62` into two parts.
#[inline(always)]
pub(super) fn parts(x: u64) -> Parts<f64> {
    debug_assert!(x < 1 << 62);
    let near = x as i64 as f64;
    [near, (x as i64 - near as i64) as f64]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fixed::Ratio;
    use crate::simd::{Level, Mask, Simd, WithSimd};

    /// Computes four quotients at an instruction level.
    struct Quotients([Ratio; 4]);
    impl WithSimd for Quotients {
        type Output = ([f64; 4], u32);
        #[inline(always)]
        fn run<S: Simd>(self) -> Self::Output {
            let two = |x: fn(Ratio) -> u128| {
                let [a, b, c, d] = self.0.map(|ratio| {
                    let near = x(ratio) as f64;
                    [near, (x(ratio) as i128 - near as i128) as f64]
                });
                [0, 1].map(|k| S::F64x4::load(&[a[k], b[k], c[k], d[k]]))
            };
            let (q, sure) = quotient(two(|ratio| ratio.num), two(|ratio| ratio.den.into()));
            let mut numbers = [0.0; 4];
            q.store(&mut numbers);
            (numbers, sure.bits())
        }
    }

    /// Tests quotients of any magnitude, including exact quotients, ties between two f64 values,
    /// and the neighbours of these ties.
    #[test]
    fn a_sure_quotient_is_the_nearest() {
        let mut state = 1_u64;
        let mut random = |bits: u32| {
            state = state.wrapping_mul(0x5851_f42d_4c95_7f2d).wrapping_add(0x1405_7b7e_f767_814f);
            let (high, low) = (state >> 32, state.rotate_left(17) & 0xffff_ffff);
            (high << 32 | low) >> (64 - bits)
        };
        let (mut unsure, mut all) = (0, 0);
        for i in 0..100_000_u32 {
            let den = random(1 + i % 62).max(1);
            // An odd 54-bit quotient lies halfway between two f64 values; a quotient of 53 bits or
            // fewer is exact.
            let bits = 1 + i / 62 % 54;
            let near = (u128::from(random(bits)) * u128::from(den)).min(1 << 64);
            let num = u128::from(random(1 + i % 64)) << (i & 1);
            let ratios =
                [num, near, near + 1, near.saturating_sub(1)].map(|num| Ratio { num, den });
            for level in Level::all() {
                let (nearest, sure) = level.run(Quotients(ratios));
                for (lane, ratio) in ratios.into_iter().enumerate().filter(|(_, r)| r.num > 0) {
                    let exact = ratio.divide(0);
                    if sure >> lane & 1 != 0 {
                        assert_eq!(nearest[lane], exact, "{ratio:?} {level:?}");
                    } else {
                        // Only a ratio that the bound cannot distinguish from a halfway point may
                        // be uncertain.
                        unsure += u32::from(level == Level::PORTABLE);
                    }
                    all += u32::from(level == Level::PORTABLE);
                }
            }
        }
        assert!(0 < unsure && unsure < all / 100, "{unsure} of {all}");
    }

    #[test]
    fn parts_are_the_number() {
        for x in [0, 1, (1 << 53) + 1, (1 << 62) - 1, (1 << 62) - 256, (1 << 62) - 257] {
            let [near, lacks] = parts(x);
            assert_eq!(near as i64 + lacks as i64, x as i64);
            assert_eq!(near + lacks, near);
        }
    }
}
