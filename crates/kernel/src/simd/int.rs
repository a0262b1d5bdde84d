//! Lanes of i64 integers, for intersection tests without rounding.

use core::ops::{Add, Sub};

use super::pair::Pair;

/// N i64 integers in lanes. `+`, `-`, and products wrap, as they do on the CPU.
///
/// A mask is a plain integer here: bit i stands for lane i.
///
/// ```
/// use intertri::simd::{Ints, Simd, WithSimd, dispatch};
///
/// /// Computes `3 x - 2^40` and the lanes in which a result is negative or 0.
/// struct Line([i64; 8]);
/// impl WithSimd for Line {
///     type Output = ([i64; 8], u32, u32);
///     #[inline(always)]
///     fn run<S: Simd>(self) -> Self::Output {
///         let x = S::I64x8::load(&self.0);
///         let y = x.times(S::I64x8::splat(3)) - S::I64x8::splat(1 << 40);
///         let mut lanes = [0; 8];
///         (y + S::I64x8::splat(0)).store(&mut lanes);
///         (lanes, y.negative(), (y - y).zero())
///     }
/// }
/// let (lanes, negative, zero) = dispatch(Line([0, 1, -7, 9, 1 << 39, 0, 0, 0]));
/// assert_eq!(lanes[..5], [0, 3, -21, 27, 3 << 39].map(|x: i64| x - (1 << 40)));
/// assert_eq!((negative, zero), (0b1110_1111, 0b1111_1111));
/// ```
pub trait Ints: Copy + Add<Output = Self> + Sub<Output = Self> {
    /// The number of lanes.
    const N: usize;

    /// Copies a value to every lane.
    fn splat(x: i64) -> Self;
    /// Loads the first N integers of a slice.
    ///
    /// # Panics
    /// Panics if the slice is shorter than N.
    fn load(from: &[i64]) -> Self;
    /// Writes the lanes to the first N elements of a slice.
    ///
    /// # Panics
    /// Panics if the slice is shorter than N.
    fn store(self, to: &mut [i64]);

    /// Returns the lower 64 bits of the product.
    fn times(self, b: Self) -> Self;

    /// Returns the lanes that are negative.
    fn negative(self) -> u32;
    /// Returns the lanes that are 0.
    fn zero(self) -> u32;
}

impl<L: Ints> Ints for Pair<L> {
    const N: usize = 2 * L::N;

    #[inline(always)]
    fn splat(x: i64) -> Self {
        Self(L::splat(x), L::splat(x))
    }
    #[inline(always)]
    fn load(from: &[i64]) -> Self {
        Self(L::load(from), L::load(&from[L::N..]))
    }
    #[inline(always)]
    fn store(self, to: &mut [i64]) {
        self.0.store(to);
        self.1.store(&mut to[L::N..]);
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

    #[inline(always)]
    fn splat(x: i64) -> Self {
        Self::new([x; 8])
    }
    #[inline(always)]
    fn load(from: &[i64]) -> Self {
        Self::new(from[..8].try_into().expect("the slice has N elements"))
    }
    #[inline(always)]
    fn store(self, to: &mut [i64]) {
        to[..8].copy_from_slice(&self.to_array());
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
