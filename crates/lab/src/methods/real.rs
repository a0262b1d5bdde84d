//! The numbers that a method computes in: f32 or f64, in any lanes.

use intertri::simd::Lanes;

/// f32 or f64: the scalars of a method's lanes.
pub trait Number: Copy + Into<f64> + Lanes<Scalar = Self> {
    /// How many significant bits it has.
    const BITS: u32;
    /// One unit in the last place of 1.
    const UNIT: f64;
    /// The nearest to an f64.
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
    /// A constant in every lane.
    #[inline(always)]
    fn of(x: f64) -> Self {
        Self::splat(Self::Scalar::nearest(x))
    }
}

impl<L: Lanes<Scalar: Number>> Real for L {}
