//! Lanes of integers that wrap, for intersection tests without rounding.

use core::ops::{Add, Sub};

use super::pair::Pair;

/// N integers in lanes. `+`, `-`, and products wrap, as they do on the CPU: they are computed modulo
/// 2^[`BITS`](Ints::BITS).
///
/// A mask is a plain integer here: bit i stands for lane i.
///
/// ```
/// use intertri::simd::{Ints, Simd, WithSimd, dispatch};
///
/// /// Returns the lanes in which `4 x - 2^40` is negative, and those in which it is 0.
/// struct Line([i64; 8]);
/// impl WithSimd for Line {
///     type Output = [u32; 2];
///     #[inline(always)]
///     fn run<S: Simd>(self) -> [u32; 2] {
///         assert!(S::I64x8::BITS == 64 && [64, 128].contains(&S::WideInts::BITS));
///         let x = S::I64x8::load(&self.0);
///         let y = x.times(S::I64x8::splat(3)) + x - S::I64x8::shifted(&[1; 8], &[40; 8]);
///         [y.negative(), y.zero()]
///     }
/// }
/// let lanes = dispatch(Line([0, 1, -7, 9, 1 << 38, 1 << 39, i64::MAX, i64::MIN]));
/// // The last two wrap.
/// assert_eq!(lanes, [0b1100_1111, 0b0001_0000]);
/// ```
pub trait Ints: Copy + Add<Output = Self> + Sub<Output = Self> {
    /// The number of lanes.
    const N: usize;
    /// The number of binary digits of each integer.
    const BITS: u32;

    /// Copies a value to every lane.
    fn splat(x: i64) -> Self;
    /// Loads the first N integers of a slice.
    ///
    /// # Panics
    /// Panics if the slice is shorter than N.
    fn load(from: &[i64]) -> Self;
    /// Loads the first N integers of a slice, and multiplies each by 2 to the power of an exponent,
    /// which must not be negative unless the integer is 0.
    ///
    /// # Panics
    /// Panics if a slice is shorter than N.
    fn shifted(from: &[i64], exponents: &[i64]) -> Self;

    /// Returns the lower digits of the product.
    fn times(self, b: Self) -> Self;

    /// Returns the lanes that are negative.
    fn negative(self) -> u32;
    /// Returns the lanes that are 0.
    fn zero(self) -> u32;
}

impl<L: Ints> Ints for Pair<L> {
    const N: usize = 2 * L::N;
    const BITS: u32 = L::BITS;

    #[inline(always)]
    fn splat(x: i64) -> Self {
        Self(L::splat(x), L::splat(x))
    }
    #[inline(always)]
    fn load(from: &[i64]) -> Self {
        Self(L::load(from), L::load(&from[L::N..]))
    }
    #[inline(always)]
    fn shifted(from: &[i64], exponents: &[i64]) -> Self {
        let last = L::shifted(&from[L::N..], &exponents[L::N..]);
        Self(L::shifted(from, exponents), last)
    }
    #[inline(always)]
    fn times(self, b: Self) -> Self {
        Self(self.0.times(b.0), self.1.times(b.1))
    }
    #[inline(always)]
    fn negative(self) -> u32 {
        self.0.negative() | self.1.negative() << L::N
    }
    #[inline(always)]
    fn zero(self) -> u32 {
        self.0.zero() | self.1.zero() << L::N
    }
}

impl Ints for ::wide::i64x8 {
    const N: usize = 8;
    const BITS: u32 = 64;

    #[inline(always)]
    fn splat(x: i64) -> Self {
        Self::new([x; 8])
    }
    #[inline(always)]
    fn load(from: &[i64]) -> Self {
        Self::new(from[..8].try_into().expect("the slice has N elements"))
    }
    #[inline(always)]
    fn shifted(from: &[i64], exponents: &[i64]) -> Self {
        Self::load(&shifted::<8>(from, exponents))
    }
    #[inline(always)]
    fn times(self, b: Self) -> Self {
        self * b
    }
    #[inline(always)]
    fn negative(self) -> u32 {
        self.to_bitmask()
    }
    #[inline(always)]
    fn zero(self) -> u32 {
        self.simd_eq(Self::new([0; 8])).to_bitmask()
    }
}

/// Multiplies N integers by powers of two, modulo 2^64.
#[inline(always)]
pub(super) fn shifted<const N: usize>(from: &[i64], exponents: &[i64]) -> [i64; N] {
    let (from, exponents) = (&from[..N], &exponents[..N]);
    let mut lanes = [0; N];
    for (lane, (x, exponent)) in lanes.iter_mut().zip(from.iter().zip(exponents)) {
        *lane = x.checked_shl(*exponent as u32).unwrap_or(0);
    }
    lanes
}
