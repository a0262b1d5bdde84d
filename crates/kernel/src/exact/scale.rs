//! Converts floats to integers: finds the common scale of a set of numbers and the number of bits
//! that their integers need.

use super::int::Int;
use super::tier::{Tier, is_f64};
use crate::Scalar;

/// The scale at which a set of floats can be represented as integers: every float is a multiple of
/// `2^low`, and its magnitude is below `2^(low + bits)`.
#[derive(Clone, Copy, Debug)]
pub(super) struct Scale {
    pub(super) low: i32,
    bits: i32,
}

impl Scale {
    /// The scale of an empty set.
    const NONE: Self = Self { low: i32::MAX / 2, bits: 0 };

    /// Returns the common scale of vectors with finite components.
    #[inline(always)]
    pub(super) fn of<S: Scalar, const N: usize>(vectors: &[[S; 3]; N]) -> Self {
        let (mut low, mut high) = (Self::NONE.low, -Self::NONE.low);
        for x in vectors.as_flattened() {
            let (m, e) = x.parts();
            // x = m 2^e. A zero has no last digit, so it does not affect the scale.
            let last = e + zeros::<S>(m);
            low = if m != 0 && last < low { last } else { low };
            high = if m != 0 && e > high { e } else { high };
        }
        Self { low, bits: (high - low + S::DIGITS).max(0) }
    }

    /// Returns the first tier whose integers are wide enough for points at this scale and a
    /// direction at the scale `dir`.
    #[inline(always)]
    pub(super) fn tier(self, dir: Self) -> Tier {
        Tier::of_bits(self.bits.max(dir.bits))
    }

    /// Converts a vector to integers.
    #[inline(always)]
    pub(super) fn vector<S: Scalar, const C: usize>(self, v: [S; 3]) -> [Int<C>; 3] {
        let int = |x: S| {
            let (m, e) = x.parts();
            // The exponent of a zero may be below `low`.
            let up = if m == 0 { 0 } else { e - self.low };
            if const { is_f64::<S>() } && up < 0 {
                // `low` is the place of the last nonzero digit, so no bits are lost.
                return Int::new(m >> -up, 0);
            }
            Int::new(m, up as u32)
        };
        [int(v[0]), int(v[1]), int(v[2])]
    }
}

/// Returns the number of trailing zero bits of an f64's integer mantissa m. Often, half of its bits
/// are trailing zeros; without them, narrower and much faster integers suffice. Returns 0 for f32,
/// because nearly all bits of an f32 are in use.
#[inline(always)]
fn zeros<S: Scalar>(m: i64) -> i32 {
    if const { is_f64::<S>() } { m.trailing_zeros() as i32 } else { 0 }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn zeros_below_the_last_digit_of_an_f64_do_not_count() {
        let (top, third) = (2.0_f64.powi(57), 1.0 / 3.0);
        // Coordinates of up to 61 bits fit in 64-bit integers.
        for (last, tier) in [(0.125, Tier::Narrow), (0.0625, Tier::Middle), (third, Tier::Middle)] {
            let vector = [top, 0.0, -last];
            let scale = Scale::of(&[vector]);
            assert_eq!(scale.tier(scale), tier, "{last}");
            let [a, zero, c] = scale.vector::<f64, 2>(vector);
            assert_eq!(zero, Int::new(0, 0));
            assert_eq!(c, Int::new(-(last * (-scale.low as f64).exp2()) as i64, 0), "{last}");
            assert_eq!(a, Int::new(1, (57 - scale.low) as u32), "{last}");
        }
        // The trailing zeros of an f32 are not removed.
        assert_eq!(Scale::of(&[[1.0_f32, 2.0, 3.0]]).low, -23);
        assert_eq!(Scale::of(&[[1.0_f64, 2.0, 3.0]]).low, 0);
    }
}
