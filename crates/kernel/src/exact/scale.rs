//! From floats to integers: what a set of numbers are multiples of, and how many bits that takes.

use super::int::Int;
use super::tier::Tier;
use crate::Scalar;

/// Numbers as integers: all are multiples of `2^low` below `2^(low + bits)`.
#[derive(Clone, Copy, Debug)]
pub(super) struct Scale {
    pub(super) low: i32,
    bits: i32,
}

impl Scale {
    /// Of no number.
    const NONE: Self = Self { low: i32::MAX / 2, bits: 0 };

    /// Of vectors of finite numbers.
    #[inline(always)]
    pub(super) fn of<S: Scalar, const N: usize>(vectors: &[[S; 3]; N]) -> Self {
        let (mut low, mut high) = (Self::NONE.low, -Self::NONE.low);
        for x in vectors.as_flattened() {
            let (m, e) = x.parts();
            low = if m != 0 && e < low { e } else { low };
            high = if m != 0 && e > high { e } else { high };
        }
        Self { low, bits: (high - low + S::DIGITS).max(0) }
    }

    /// The first tier whose integers hold the numbers of two scales, one of points, one of a direction.
    #[inline(always)]
    pub(super) fn tier<S: Scalar>(self, dir: Self) -> Tier {
        Tier::of_bits::<S>(self.bits.max(dir.bits))
    }

    /// A vector as integers.
    #[inline(always)]
    pub(super) fn vector<S: Scalar, const C: usize>(self, v: [S; 3]) -> [Int<C>; 3] {
        let int = |x: S| {
            let (m, e) = x.parts();
            // A zero may have a smaller exponent than any.
            Int::new(m, if m == 0 { 0 } else { (e - self.low) as u32 })
        };
        [int(v[0]), int(v[1]), int(v[2])]
    }
}
