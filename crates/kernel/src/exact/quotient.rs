//! The quotient of two integers, stored as its first 64 bits and a flag that is set if nonzero bits
//! follow. This is enough to round the quotient correctly and to compare it with any float.
//!
//! ```text
//!   1.b₁b₂b₃ ... b₅₂ | b₅₃ ... b₆₃ | more?        These bits suffice to round to nearest even.
//! ```

use core::cmp::Ordering;

use super::int::{minus, plus};
use super::scale::Dyadic;
use crate::scalar::Bits;
use crate::simd::Lanes;

/// A positive quotient: `first * 2^exponent`, plus a remainder of less than `2^exponent`.
#[derive(Clone, Copy, Debug)]
pub(super) struct Quotient {
    /// The first 64 bits, of which the highest is set.
    first: u64,
    /// Whether nonzero bits follow the first 64 bits.
    more: bool,
    exponent: i32,
}

impl Quotient {
    /// Computes `num / den * 2^exponent` for positive integers.
    #[inline(never)]
    pub(super) fn new<const V: usize>(num: &[u64; V], den: &[u64; V], exponent: i32) -> Self {
        // Shift both integers until their highest bit is set, so that their quotient is between 1/2
        // and 2.
        let ((num, up), (den, down)) = (from_the_top(num), from_the_top(den));
        // If the normalized numerator is smaller, the quotient is below 1 and needs one more binary
        // place to fill all 64 bits.
        let less = num.iter().rev().lt(den.iter().rev());
        let exponent = exponent + down - up - 63 - i32::from(less);

        // The dividend has one more limb, `top`, which is at most the divisor's highest limb. If
        // they are equal, the trial digit is `u64::MAX`.
        let mut rest = [0; V];
        rest[1..].copy_from_slice(&num[..V - 1]);
        let mut top = num[V - 1];
        if !less {
            for i in 0..V {
                let above = if i + 1 < V { rest[i + 1] } else { top };
                rest[i] = rest[i] >> 1 | above << 63;
            }
            top >>= 1;
        }

        // Compute one digit with Knuth's algorithm D: the quotient of the first two limbs and the
        // divisor's first limb is too large by at most two.
        let two = u128::from(top) << 64 | u128::from(rest[V - 1]);
        let mut first = u64::try_from(two / u128::from(den[V - 1])).unwrap_or(u64::MAX);
        let (mut carry, mut borrow) = (0, false);
        for i in 0..V {
            let product = u128::from(first) * u128::from(den[i]) + u128::from(carry);
            carry = (product >> 64) as u64;
            (rest[i], borrow) = minus(rest[i], product as u64, borrow);
        }
        top = top.wrapping_sub(carry).wrapping_sub(borrow.into());
        // If the digit is too large, the remainder is negative, and the divisor is added back. By
        // Knuth's theorem B, this happens at most twice.
        while top != 0 {
            first -= 1;
            let mut carry = false;
            for i in 0..V {
                (rest[i], carry) = plus(rest[i], den[i], carry);
            }
            top = top.wrapping_add(carry.into());
        }
        Self { first, more: rest.iter().any(|&limb| limb != 0), exponent }
    }

    /// Multiplies by a power of two.
    pub(super) fn times_pow2(self, exponent: i32) -> Self {
        Self { exponent: self.exponent + exponent, ..self }
    }

    /// Rounds to the nearest f64, ties to even. Returns infinity if the value rounds to more than
    /// the largest f64.
    #[inline(always)]
    pub(super) fn to_f64(self) -> f64 {
        // An f64 holds eleven bits fewer than `first`, so the sticky bit can be merged into the
        // last bit.
        let first = self.first | u64::from(self.more);
        // The value is at least 2^top and less than twice that.
        let top = self.exponent.saturating_add(63);
        if (SMALLEST..=LARGEST).contains(&top) {
            // The conversion rounds once. The two multiplications are by powers of two and have
            // normal results, so they are exact. The one exception is intended: if the mantissa
            // rounds up to 2^64 and `top` is 1023, the second product overflows to infinity.
            return first as f64 * pow2(-63) * pow2(top);
        }
        if top > LARGEST { f64::INFINITY } else { f64::from_bits(subnormal(first, top, -1074)) }
    }

    /// Like [`Quotient::to_f64`], but for f32.
    pub(super) fn to_f32(self) -> f32 {
        let first = self.first | u64::from(self.more);
        let top = self.exponent.saturating_add(63);
        if (SMALLEST_F32..=LARGEST_F32).contains(&top) {
            // The scaled mantissa is at most 2; if it rounds up to 2, its product with the largest
            // power overflows to infinity, as it should.
            let power = f32::from_bits(((top + 127) as u32) << 23);
            return first as f32 * f32::from_bits((127 - 63) << 23) * power;
        }
        if top > LARGEST_F32 {
            return f32::INFINITY;
        }
        f32::from_bits(subnormal(first, top, -149) as u32)
    }

    /// Returns the square root, rounded twice. The error is at most 0.86 units in the last place,
    /// or 0.93 if the result is subnormal. The result is never 0, and it is infinite if it exceeds
    /// the largest f64.
    #[inline(always)]
    pub(super) fn to_sqrt(self) -> f64 {
        // An even exponent can be halved exactly. If the exponent is odd, decrease it by 1 and
        // multiply the mantissa by 2.
        let odd = self.exponent & 1;
        let size = (self.first | u64::from(self.more)) as f64 * f64::from(1 + odd);
        let root = Lanes::sqrt(size);
        let up = if root < pow2(32) { 31 } else { 32 };
        let (root, top) = (root * pow2(-up), (self.exponent - odd) / 2 + up);
        if (SMALLEST..=LARGEST).contains(&top) {
            return root * pow2(top);
        }
        if top > LARGEST {
            return f64::INFINITY;
        }
        let (m, _) = root.parts();
        f64::from_bits(subnormal((m as u64) << 11, top, -1074).max(1))
    }

    /// Compares the quotient with a positive number.
    #[inline(always)]
    pub(super) fn cmp_number(self, Dyadic { m, e }: Dyadic) -> Ordering {
        // Normalize the number in the same way. Then compare the exponents, then the first 64 bits,
        // and then whether nonzero bits follow.
        let up = m.leading_zeros();
        let (first, exponent) = ((m as u64) << up, e - up as i32);
        (self.exponent, self.first, self.more).cmp(&(exponent, first, false))
    }
}

/// Shifts the limbs of a positive number left until the highest bit is set. Returns the shifted
/// limbs and the number of bits by which they were shifted.
#[inline(always)]
fn from_the_top<const V: usize>(limbs: &[u64; V]) -> ([u64; V], i32) {
    // Shift by whole limbs, then by bits.
    let mut all = *limbs;
    let mut up = 0;
    // The number is positive, so this loop ends.
    while all[V - 1] == 0 {
        all.copy_within(..V - 1, 1);
        all[0] = 0;
        up += 64;
    }
    let shift = all[V - 1].leading_zeros();
    if shift > 0 {
        for i in (1..V).rev() {
            all[i] = all[i] << shift | all[i - 1] >> (64 - shift);
        }
        all[0] <<= shift;
    }
    (all, up + shift as i32)
}

/// The smallest exponent of a normal f64.
const SMALLEST: i32 = -1022;
/// The largest exponent of a normal f64.
const LARGEST: i32 = 1023;

/// The smallest exponent of a normal f32.
const SMALLEST_F32: i32 = -126;
/// The largest exponent of a normal f32.
const LARGEST_F32: i32 = 127;

/// Rounds 64 bits, the highest of which has the value `2^top`, to a subnormal number whose lowest
/// bit has the value `2^last`. Rounds to nearest, ties to even. Returns the bits of the result.
#[cold]
fn subnormal(first: u64, top: i32, last: i32) -> u64 {
    // The number of bits below the lowest bit of the result.
    let after = last.saturating_sub(top.saturating_sub(63));
    if after > 64 {
        return 0;
    }
    let all = u128::from(first);
    let (kept, rest) = ((all >> after) as u64, all & ((1 << after) - 1));
    let half = 1 << (after - 1);
    // Round to nearest, ties to even. If `kept + 1` is the smallest normal number, the bits are
    // still correct.
    let up = rest > half || rest == half && kept & 1 != 0;
    kept + u64::from(up)
}

/// Returns `2^e`, which must be a normal number.
pub(super) const fn pow2(e: i32) -> f64 {
    f64::from_bits(((e + 1023) as u64) << 52)
}
