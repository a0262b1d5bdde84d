//! Lanes of floating-point numbers, and masks.

use core::ops::{Add, BitAnd, BitOr, Div, Mul, Neg, Not, Sub};

/// N floating-point numbers, f32 or f64, in lanes.
///
/// `+ - * /`, negation, [`Lanes::abs`], [`Lanes::sqrt`], and comparisons follow IEEE 754: they are
/// correctly rounded, lane by lane, and the same at every level. They are never fused or
/// reassociated. Only [`Lanes::mul_add`] may round either once or twice.
///
/// ```
/// use intertri::simd::{Lanes, Mask};
///
/// /// Computes the distance of each value from an interval. The distance is 0 inside.
/// fn outside<L: Lanes<Scalar = f32>>(x: L, lo: L, hi: L) -> L {
///     let out = x.lt(lo) | x.gt(hi);
///     L::select(out, (lo - x).max(x - hi), L::splat(0.0))
/// }
/// // An f32 counts as one lane. f32 has methods with the same names, so the calls name the trait.
/// assert_eq!([3.0_f32, -1.0, 9.0].map(|x| outside(x, 0.0, 5.0)), [0.0, 1.0, 4.0]);
/// assert_eq!((Lanes::min(1.0_f32, 2.0), Lanes::max(1.0_f32, 2.0)), (1.0, 2.0));
/// assert_eq!((Lanes::abs(-3.0_f32), Lanes::sqrt(9.0_f64)), (3.0, 3.0));
/// let (third, one) = (1.0 / 3.0, 1.0_f64);
/// assert_eq!(Lanes::mul_error(third, 3.0, one), (third - 0.25) * 3.0 - 0.25);
/// assert_eq!((Lanes::mul_add(2.0_f64, 3.0, 4.0), Lanes::power(10.0_f64)), (10.0, 8.0));
/// assert!(Lanes::le(1.0_f32, 1.0) && Lanes::ge(1.0_f32, 1.0) && !Lanes::ge(f32::NAN, 1.0));
///
/// // Signs.
/// assert_eq!((Lanes::flip(2.0_f32, -1.0), Lanes::flip(-2.0_f32, -1.0)), (-2.0, 2.0));
/// assert!(Lanes::negative(Lanes::or_sign(2.0_f32, -1.0)) && !Lanes::negative(1.0_f32));
///
/// // To and from slices.
/// let mut rounded = [0.0_f32];
/// <f64 as Lanes>::load_f32(&[0.5]).store_f32(&mut rounded);
/// let mut kept = [0.0_f64];
/// <f64 as Lanes>::load(&[0.5]).store(&mut kept);
/// assert_eq!((rounded, kept, <f64 as Lanes>::N), ([0.5], [0.5], 1));
/// ```
pub trait Lanes:
    Copy
    + Add<Output = Self>
    + Sub<Output = Self>
    + Mul<Output = Self>
    + Div<Output = Self>
    + Neg<Output = Self>
{
    /// The type of one lane: f32 or f64.
    type Scalar: Copy;
    /// A mask with one bool per lane.
    type Mask: Mask;
    /// The number of lanes.
    const N: usize;

    /// Copies a value to every lane.
    fn splat(x: Self::Scalar) -> Self;
    /// Loads the first N elements of a slice.
    ///
    /// # Panics
    /// Panics if the slice is shorter than N.
    fn load(from: &[Self::Scalar]) -> Self;
    /// Loads the first N f32 elements of a slice and converts them. For f64 lanes, the conversion
    /// is exact.
    ///
    /// # Panics
    /// Panics if the slice is shorter than N.
    fn load_f32(from: &[f32]) -> Self;
    /// Writes the lanes to the first N elements of a slice.
    ///
    /// # Panics
    /// Panics if the slice is shorter than N.
    fn store(self, to: &mut [Self::Scalar]);
    /// Writes the lanes, rounded to f32, to the first N elements of a slice.
    ///
    /// # Panics
    /// Panics if the slice is shorter than N.
    fn store_f32(self, to: &mut [f32]);

    /// Computes `self * b + c`, rounded once if the CPU supports that, otherwise twice.
    fn mul_add(self, b: Self, c: Self) -> Self;
    /// Computes the rounding error of `product`, which must be `self * b`. The result is exact
    /// unless an intermediate value overflows or underflows.
    fn mul_error(self, b: Self, product: Self) -> Self;
    /// Returns the larger of two values, or either of them if one is NaN.
    fn max(self, other: Self) -> Self;
    /// Returns the smaller of two values, or either of them if one is NaN.
    fn min(self, other: Self) -> Self;
    /// Returns the absolute value.
    fn abs(self) -> Self;
    /// Returns the largest power of two that does not exceed the value. The value must be positive
    /// and normal; otherwise, the result is meaningless.
    fn power(self) -> Self;
    /// Flips the sign in lanes where the sign bit of `of` is set.
    fn flip(self, of: Self) -> Self;
    /// Returns a value whose sign bit is set if the sign bit of either operand is set. Its
    /// magnitude is arbitrary.
    fn or_sign(self, other: Self) -> Self;
    /// Returns the lanes whose sign bit is set. For a zero or a NaN whose sign bit is set, the
    /// result is arbitrary.
    fn negative(self) -> Self::Mask;
    /// Returns the square root, correctly rounded.
    fn sqrt(self) -> Self;

    /// Computes `self < other`, which is false for NaN, like all comparisons.
    fn lt(self, other: Self) -> Self::Mask;
    /// Computes `self <= other`.
    fn le(self, other: Self) -> Self::Mask;
    /// Computes `self > other`.
    #[inline(always)]
    fn gt(self, other: Self) -> Self::Mask {
        other.lt(self)
    }
    /// Computes `self >= other`.
    #[inline(always)]
    fn ge(self, other: Self) -> Self::Mask {
        other.le(self)
    }
    /// Computes `if mask { yes } else { no }` in each lane.
    fn select(mask: Self::Mask, yes: Self, no: Self) -> Self;
}

/// A mask: one bool per lane.
///
/// ```
/// use intertri::simd::Mask;
/// // A bool counts as a mask with one lane.
/// assert_eq!((bool::from_bits(0b1), true.bits(), <bool as Mask>::N), (true, 0b1, 1));
/// assert!(!(true & false).any() && (true | false).any());
/// ```
pub trait Mask: Copy + BitAnd<Output = Self> + BitOr<Output = Self> + Not<Output = Self> {
    /// The number of lanes.
    const N: usize;

    /// Returns the mask as bits: bit i is lane i, and the bits above the last lane are 0.
    fn bits(self) -> u32;
    /// Returns the bits of a mask with twice as many lanes: this mask, followed by `last`.
    #[doc(hidden)]
    #[inline(always)]
    fn bits_of_two(self, last: Self) -> u32 {
        self.bits() | last.bits() << Self::N
    }
    /// Creates a mask from bits: lane i is bit i, and the bits above the last lane are ignored.
    fn from_bits(bits: u32) -> Self;
    /// Returns whether any lane is true.
    #[inline(always)]
    fn any(self) -> bool {
        self.bits() != 0
    }
}

/// Computes [`Lanes::mul_error`] without fused operations, by splitting the factors into halves,
/// whose products are exact. `split` is `2^k + 1`, where k is half the number of digits, rounded
/// up.
///
/// Dekker, A Floating-Point Technique for Extending the Available Precision, 1971.
#[inline(always)]
pub(super) fn mul_error<L: Lanes>(a: L, b: L, product: L, split: L) -> L {
    // Adding and subtracting a large multiple rounds a factor to its upper half. The lower half is
    // the exact remainder.
    let (by_a, by_b) = (a * split, b * split);
    let (a_high, b_high) = (by_a - (by_a - a), by_b - (by_b - b));
    let (a_low, b_low) = (a - a_high, b - b_high);
    // Products of halves are exact. Subtracting them from the rounded product in this order loses
    // nothing.
    a_low * b_low - (((product - a_high * b_high) - a_low * b_high) - a_high * b_low)
}

/// Iterates over the lanes whose bits are set in a mask, starting from the lowest.
#[inline(always)]
pub fn lanes_of(mut bits: u32) -> impl Iterator<Item = usize> {
    core::iter::from_fn(move || {
        let lane = bits.trailing_zeros() as usize;
        // Clear the lowest set bit. A mask of 0 has 32 trailing zeros, which ends the iteration.
        bits &= bits.wrapping_sub(1);
        (lane < 32).then_some(lane)
    })
}
