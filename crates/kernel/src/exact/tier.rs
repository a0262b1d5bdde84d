//! The tiers: f64 under a bound, then integers of three widths, the last of which holds any f32.

/// What decides, from the fastest to the one that always can.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Tier {
    /// f64, where its bound tells.
    Float,
    /// Coordinates of 64 bits.
    Narrow,
    /// Coordinates of 128 bits.
    Middle,
    /// Coordinates of 320 bits: any f32, whose exponents span 277.
    Widest,
}

impl Tier {
    /// All of them.
    pub const ALL: [Self; 4] = [Self::Float, Self::Narrow, Self::Middle, Self::Widest];

    /// The first whose integers hold coordinates of so many bits, with the three that the proof asks for.
    #[inline(always)]
    pub(super) fn of_bits(bits: i32) -> Self {
        match bits + 3 {
            ..=64 => Self::Narrow,
            65..=128 => Self::Middle,
            _ => Self::Widest,
        }
    }
}

/// Calls a function that is generic over the limbs of coordinates, normals and volumes (and of products
/// of two volumes), at the widths of a tier.
macro_rules! at_tier {
    ($tier:expr, $f:ident::<C, N, V>($($arg:expr),*)) => {
        match $tier {
            Tier::Float | Tier::Narrow => $f::<1, 2, 3>($($arg),*),
            Tier::Middle => $f::<2, 4, 6>($($arg),*),
            Tier::Widest => $f::<5, 10, 15>($($arg),*),
        }
    };
    ($tier:expr, $f:ident::<C, N, V, P>($($arg:expr),*)) => {
        match $tier {
            Tier::Float | Tier::Narrow => $f::<1, 2, 3, 6>($($arg),*),
            Tier::Middle => $f::<2, 4, 6, 12>($($arg),*),
            Tier::Widest => $f::<5, 10, 15, 30>($($arg),*),
        }
    };
}
pub(super) use at_tier;
