//! The numeric types that methods use: f32 or f64, in any number of lanes.

use intertri::simd::Lanes;

/// f32 or f64, the scalar type of a method's lanes.
pub trait Number: Copy + Into<f64> + Lanes<Scalar = Self> {
    /// The number of significant bits.
    const BITS: u32;
    /// The unit in the last place of 1.
    const UNIT: f64;
    /// Rounds an f64 to the nearest value of this type.
    fn nearest(x: f64) -> Self;
}

impl Number for f32 {
    const BITS: u32 = Self::MANTISSA_DIGITS;
    const UNIT: f64 = Self::EPSILON as f64;
    #[inline(always)]
    fn nearest(x: f64) -> Self {
        x as Self
    }
}

impl Number for f64 {
    const BITS: u32 = Self::MANTISSA_DIGITS;
    const UNIT: f64 = Self::EPSILON;
    #[inline(always)]
    fn nearest(x: f64) -> Self {
        x
    }
}

/// Lanes of f32 or f64.
pub trait Real: Lanes<Scalar: Number> {
    /// Copies a constant to every lane.
    #[inline(always)]
    fn of(x: f64) -> Self {
        Self::splat(Self::Scalar::nearest(x))
    }
}

impl<L: Lanes<Scalar: Number>> Real for L {}
