//! The tiers of arithmetic: f64 with an error bound, then integers of increasing width. The widest
//! integers are sufficient for any input.

use crate::Scalar;

/// The tiers of arithmetic, from the fastest to the one that can decide every pair.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Tier {
    /// f64 with an error bound, for pairs that the bound can decide.
    Float,
    /// Integers, with 64-bit coordinates.
    Narrow,
    /// Integers, with 128-bit coordinates.
    Middle,
    /// Integers, with 320-bit coordinates: enough for all f32 values, whose bits span 277 places.
    Wide,
    /// Integers, with 2112-bit coordinates: enough for all f64 values, whose bits span 2098 places.
    /// f32 coordinates never need more than 320 bits.
    Widest,
}

impl Tier {
    /// Returns all tiers that coordinates of this type may need.
    pub fn all<S: Scalar>() -> &'static [Self] {
        const ALL: [Tier; 5] = [Tier::Float, Tier::Narrow, Tier::Middle, Tier::Wide, Tier::Widest];
        if const { is_f64::<S>() } { &ALL } else { &ALL[..4] }
    }

    /// Returns the first tier whose integers are wide enough for coordinates with this many bits,
    /// plus three bits that the proof requires.
    #[inline(always)]
    pub(super) fn of_bits(bits: i32) -> Self {
        match bits + 3 {
            ..=64 => Self::Narrow,
            65..=128 => Self::Middle,
            129..=320 => Self::Wide,
            _ => Self::Widest,
        }
    }
}

/// Returns whether the scalar type is f64.
#[inline(always)]
pub(super) const fn is_f64<S: Scalar>() -> bool {
    S::DIGITS > f32::MANTISSA_DIGITS as i32
}

/// Calls a function with the integer widths of a tier. The function is generic over the numbers of
/// limbs in coordinates, normals, and volumes, and optionally in products of two volumes.
macro_rules! at_tier {
    ($tier:expr, $f:ident::<C, N, V>($($arg:expr),*)) => {
        match $tier {
            Tier::Float | Tier::Narrow => $f::<1, 2, 3>($($arg),*),
            Tier::Middle => $f::<2, 4, 6>($($arg),*),
            Tier::Wide => $f::<5, 10, 15>($($arg),*),
            Tier::Widest => $f::<33, 66, 99>($($arg),*),
        }
    };
    ($tier:expr, $f:ident::<C, N, V, P>($($arg:expr),*)) => {
        match $tier {
            Tier::Float | Tier::Narrow => $f::<1, 2, 3, 6>($($arg),*),
            Tier::Middle => $f::<2, 4, 6, 12>($($arg),*),
            Tier::Wide => $f::<5, 10, 15, 30>($($arg),*),
            Tier::Widest => $f::<33, 66, 99, 198>($($arg),*),
        }
    };
}
pub(super) use at_tier;
