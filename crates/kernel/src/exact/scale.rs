//! Converts floats to integers: finds the common scale of a set of numbers and the number of bits
//! that their integers need.

use super::int::{self, Int};
use super::tier::Tier;
use crate::Scalar;

/// A finite number `m * 2^e`, where m is odd or 0; if it is 0, e is arbitrary. All code that computes
/// with [`Int`] takes these instead of f32 or f64, so it is compiled once.
#[derive(Clone, Copy, Debug)]
pub(super) struct Dyadic {
    pub(super) m: i64,
    pub(super) e: i32,
}

impl Dyadic {
    /// Converts a finite float.
    #[inline(always)]
    pub(super) fn of<S: Scalar>(x: S) -> Self {
        let (m, e) = x.parts();
        // Often, half of the bits are trailing zeros; without them, narrower and much faster
        // integers suffice.
        let zeros = m.trailing_zeros() & 63;
        Self { m: m >> zeros, e: e + zeros as i32 }
    }

    /// Converts a vector with finite components.
    #[inline(always)]
    pub(super) fn vector<S: Scalar>(v: [S; 3]) -> [Self; 3] {
        v.map(Self::of)
    }
}

/// The scale at which a set of numbers can be represented as integers: every number is a multiple of
/// `2^low`, and its magnitude is below `2^(low + bits)`.
#[derive(Clone, Copy, Debug)]
pub(super) struct Scale {
    pub(super) low: i32,
    bits: i32,
}

impl Scale {
    /// The scale of an empty set.
    const NONE: Self = Self { low: i32::MAX / 2, bits: 0 };

    /// Returns the common scale of vectors.
    #[inline(always)]
    pub(super) fn of(vectors: &[[Dyadic; 3]]) -> Self {
        let (mut low, mut high) = (Self::NONE.low, -Self::NONE.low);
        for &Dyadic { m, e } in vectors.as_flattened() {
            // A zero has no digits, so it does not affect the scale.
            let end = e + 64 - m.unsigned_abs().leading_zeros() as i32;
            low = if m != 0 && e < low { e } else { low };
            high = if m != 0 && end > high { end } else { high };
        }
        Self { low, bits: (high - low).max(0) }
    }

    /// Returns the first tier whose integers are wide enough for this scale.
    #[inline(always)]
    pub(super) fn tier(self) -> Tier {
        Tier::of_bits(self.bits)
    }

    /// Converts a vector to integers.
    #[inline(always)]
    pub(super) fn vector<const C: usize>(self, v: [Dyadic; 3]) -> [Int<C>; 3] {
        // The exponent of a zero may be below `low`.
        v.map(|Dyadic { m, e }| Int::new(m, if m == 0 { 0 } else { (e - self.low) as u32 }))
    }

    /// Returns the differences between points and an origin, as integers. In floating point, they
    /// could round.
    #[inline(always)]
    pub(super) fn relative<const C: usize, const N: usize>(
        self,
        origin: [Dyadic; 3],
        points: [[Dyadic; 3]; N],
    ) -> [[Int<C>; 3]; N] {
        let o = self.vector(origin);
        points.map(|point| int::difference(&self.vector(point), &o))
    }
}

/// The scale of a ray's origin and other points, and the scale of its direction.
#[derive(Clone, Copy)]
pub(super) struct Scales {
    pub(super) points: Scale,
    pub(super) dir: Scale,
}

impl Scales {
    /// Returns the scales of points and a direction.
    #[inline(always)]
    pub(super) fn of(points: &[[Dyadic; 3]], dir: [Dyadic; 3]) -> Self {
        Self { points: Scale::of(points), dir: Scale::of(&[dir]) }
    }

    /// Returns the first tier whose integers are wide enough for both scales.
    #[inline(always)]
    pub(super) fn tier(self) -> Tier {
        Tier::of_bits(self.points.bits.max(self.dir.bits))
    }

    /// Returns the exponent of the power of two that converts the integer quotient T/D to t.
    #[inline(always)]
    pub(super) fn of_t(self) -> i32 {
        self.points.low - self.dir.low
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn zeros_below_the_last_digit_do_not_count() {
        let (top, third) = (2.0_f64.powi(57), 1.0 / 3.0);
        // Coordinates of up to 61 bits fit in 64-bit integers.
        for (last, tier) in [(0.125, Tier::Narrow), (0.0625, Tier::Middle), (third, Tier::Middle)] {
            let vector = [top, 0.0, -last];
            let vector = Dyadic::vector(vector);
            let scale = Scale::of(&[vector]);
            assert_eq!(scale.tier(), tier, "{last}");
            let [a, zero, c] = scale.vector::<2>(vector);
            assert_eq!(zero, Int::new(0, 0));
            assert_eq!(c, Int::new(-(last * (-scale.low as f64).exp2()) as i64, 0), "{last}");
            assert_eq!(a, Int::new(1, (57 - scale.low) as u32), "{last}");
        }
        assert_eq!(Scale::of(&[Dyadic::vector([1.0_f32, 2.0, 6.0])]).low, 0);
    }
}
