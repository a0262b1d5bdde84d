//! The scalar types of coordinates: f32 and f64.

use core::fmt;

use bytemuck::Pod;

/// The scalar type of coordinates: f32 or f64. Do not implement this trait for other types.
///
/// ```
/// use intertri::{Scalar, TriangleOf};
/// /// Computes the centroid of a triangle in f64.
/// fn middle<S: Scalar>(triangle: &TriangleOf<S>) -> [f64; 3] {
///     [0, 1, 2].map(|k| triangle.0.iter().map(|corner| Into::<f64>::into(corner[k])).sum::<f64>() / 3.0)
/// }
/// assert_eq!(middle(&intertri::Triangle64([[0.0; 3], [3.0, 0.0, 0.0], [0.0, 6.0, 0.0]])), [1.0, 2.0, 0.0]);
/// ```
pub trait Scalar:
    Pod + PartialOrd + fmt::Debug + fmt::Display + Default + From<f32> + Into<f64> + Send + Sync + Bits
{
    /// 0.
    const ZERO: Self;
    /// 1.
    const ONE: Self;
    /// The far end of an unbounded ray.
    const INFINITY: Self;
}

impl Scalar for f32 {
    const ZERO: Self = 0.0;
    const ONE: Self = 1.0;
    const INFINITY: Self = Self::INFINITY;
}

impl Scalar for f64 {
    const ZERO: Self = 0.0;
    const ONE: Self = 1.0;
    const INFINITY: Self = Self::INFINITY;
}

/// Operations on the bits of a float. They work even on a CPU that is set to read subnormal numbers
/// as zero.
///
/// This trait is hidden because users should not implement [`Scalar`].
pub trait Bits: Copy {
    /// An integer that holds the bits, with the same value for both zeros.
    type Key: Copy + Ord + fmt::Debug + Send + Sync;

    /// Converts the number to a key.
    fn key(self) -> Self::Key;

    /// Converts a key back to a number. The key of zero becomes +0.
    fn of_key(key: Self::Key) -> Self;

    /// The maximum number of bits in the m of [`Bits::parts`].
    const DIGITS: i32;

    /// Returns the m and e of a finite number `m * 2^e`. For zero, m is 0 and e is arbitrary.
    fn parts(self) -> (i64, i32);

    /// Returns the number nearest to an f64. The result is infinite if the f64 is too large.
    fn nearest(x: f64) -> Self;

    /// The smallest positive normal number.
    const LEAST_NORMAL: f64;

    /// Returns whether the number is neither NaN nor infinite.
    fn is_finite(self) -> bool;

    /// Returns whether the sign bit is set, even for a zero or a NaN.
    fn is_negative(self) -> bool;

    /// Returns an integer that orders floats by magnitude: 0 for zero, [`Bits::ENDLESS`] for
    /// infinity, and larger for NaN.
    fn rank(self) -> u64;

    /// The [`Bits::rank`] of infinity.
    const ENDLESS: u64;
}

impl Bits for f32 {
    type Key = u32;

    #[inline(always)]
    fn key(self) -> u32 {
        if self.rank() == 0 { 0 } else { self.to_bits() }
    }

    #[inline(always)]
    fn of_key(key: u32) -> Self {
        Self::from_bits(key)
    }

    const DIGITS: i32 = Self::MANTISSA_DIGITS as i32;
    const ENDLESS: u64 = Self::INFINITY.to_bits() as u64;
    const LEAST_NORMAL: f64 = Self::MIN_POSITIVE as f64;

    #[inline(always)]
    fn nearest(x: f64) -> Self {
        x as Self
    }

    #[inline(always)]
    fn parts(self) -> (i64, i32) {
        let bits = self.to_bits();
        let (field, fraction) = (bits >> 23 & 0xff, i64::from(bits & 0x7f_ffff));
        // Subnormal numbers lack the leading 1 and have the exponent of the smallest normal
        // numbers.
        let size = if field == 0 { fraction } else { fraction | 1 << 23 };
        (if bits >> 31 == 0 { size } else { -size }, field.max(1) as i32 - 150)
    }

    #[inline(always)]
    fn is_finite(self) -> bool {
        self.rank() < Self::ENDLESS
    }

    #[inline(always)]
    fn is_negative(self) -> bool {
        self.to_bits() >> 31 != 0
    }

    #[inline(always)]
    fn rank(self) -> u64 {
        u64::from(self.to_bits() & (u32::MAX >> 1))
    }
}

impl Bits for f64 {
    type Key = u64;

    #[inline(always)]
    fn key(self) -> u64 {
        if self.rank() == 0 { 0 } else { self.to_bits() }
    }

    #[inline(always)]
    fn of_key(key: u64) -> Self {
        Self::from_bits(key)
    }

    const DIGITS: i32 = Self::MANTISSA_DIGITS as i32;
    const ENDLESS: u64 = Self::INFINITY.to_bits();
    const LEAST_NORMAL: f64 = Self::MIN_POSITIVE;

    #[inline(always)]
    fn nearest(x: f64) -> Self {
        x
    }

    #[inline(always)]
    fn parts(self) -> (i64, i32) {
        let bits = self.to_bits();
        let (field, fraction) = ((bits >> 52) as i32 & 0x7ff, (bits & ((1 << 52) - 1)) as i64);
        let size = if field == 0 { fraction } else { fraction | 1 << 52 };
        (if bits >> 63 == 0 { size } else { -size }, field.max(1) - 1075)
    }

    #[inline(always)]
    fn is_finite(self) -> bool {
        self.rank() < Self::ENDLESS
    }

    #[inline(always)]
    fn is_negative(self) -> bool {
        self.to_bits() >> 63 != 0
    }

    #[inline(always)]
    fn rank(self) -> u64 {
        self.to_bits() & (u64::MAX >> 1)
    }
}
