//! Lanes: N numbers side by side, and the one place that knows what the CPU has.
//!
//! Every algorithm of the house is written once, generic over [`Lanes`] or [`Simd`], and reaches
//! the CPU's widest registers through [`dispatch`]. All `unsafe` of the workspace is in this folder.
//!
//! ```text
//!   algorithm<S: Simd>  ──►  dispatch ──► Scalar   plain f32 and f64, one at a time
//!                                    ├──► Wide     the crate `wide`, what the build was compiled for
//!                                    ├──► Sse41    the same, with integers of 128 bits
//!                                    ├──► Avx2     256 bits, fused multiply-add
//!                                    └──► Avx512   512 bits, mask registers
//! ```

/// Calls an intrinsic that a level has, for the files of x86's registers.
#[cfg(target_arch = "x86_64")]
macro_rules! cpu {
    ($call:expr) => {
        // SAFETY: lanes of this level exist only where the CPU has its instructions.
        unsafe { $call }
    };
}

#[cfg(target_arch = "x86_64")]
mod across_x86;
mod int;
#[cfg(target_arch = "x86_64")]
mod int_x86;
mod level;
mod pair;
mod scalar;
mod wide;
#[cfg(target_arch = "x86_64")]
mod x86;

use core::ops::{Add, BitAnd, BitOr, Div, Mul, Neg, Not, Sub};

pub use int::Ints;
pub(crate) use int::One;
pub use level::{Level, WithSimd, dispatch, prefetch, prefetch_early};
pub(crate) use pair::Pair;

/// N numbers side by side, f32 or f64.
///
/// `+ - * /`, negation, [`Lanes::abs`], [`Lanes::sqrt`] and comparisons are IEEE 754's, lane by lane
/// and correctly rounded, the same at every level; they are never fused or reassociated. Only
/// [`Lanes::mul_add`] may round once or twice.
///
/// ```
/// use intertri::lanes::{Lanes, Mask};
///
/// /// How far numbers are outside of an interval.
/// fn outside<L: Lanes<Scalar = f32>>(x: L, lo: L, hi: L) -> L {
///     let out = x.lt(lo) | x.gt(hi);
///     L::select(out, (lo - x).max(x - hi), L::splat(0.0))
/// }
/// // One f32 is a lane, too; f32 has methods of the same names, so the trait's are named here.
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
/// // From and to slices.
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
    /// One lane: f32 or f64.
    type Scalar: Copy;
    /// One truth a lane.
    type Mask: Mask;
    /// How many lanes there are.
    const N: usize;

    /// The same number in every lane.
    fn splat(x: Self::Scalar) -> Self;
    /// The first N numbers of a slice.
    ///
    /// # Panics
    /// Where the slice is shorter than N.
    fn load(from: &[Self::Scalar]) -> Self;
    /// The first N f32 of a slice, converted (exactly, for f64 lanes).
    ///
    /// # Panics
    /// Where the slice is shorter than N.
    fn load_f32(from: &[f32]) -> Self;
    /// Writes the lanes to the first N places of a slice.
    ///
    /// # Panics
    /// Where the slice is shorter than N.
    fn store(self, to: &mut [Self::Scalar]);
    /// Writes the lanes, rounded to f32, to the first N places of a slice.
    ///
    /// # Panics
    /// Where the slice is shorter than N.
    fn store_f32(self, to: &mut [f32]);

    /// `self * b + c`, rounded once where the CPU can, else twice.
    fn mul_add(self, b: Self, c: Self) -> Self;
    /// What `product`, which is `self * b`, lacks of the exact product: exactly, where no number is too
    /// large or too small.
    fn mul_error(self, b: Self, product: Self) -> Self;
    /// The larger; where one is NaN, either.
    fn max(self, other: Self) -> Self;
    /// The smaller; where one is NaN, either.
    fn min(self, other: Self) -> Self;
    /// Without its sign.
    fn abs(self) -> Self;
    /// The largest power of two that is not larger, of a positive normal number; of others, any number.
    fn power(self) -> Self;
    /// With its sign flipped where `of` has the sign bit set.
    fn flip(self, of: Self) -> Self;
    /// A number that has its sign bit set where either has it; what else it is does not count.
    fn or_sign(self, other: Self) -> Self;
    /// Where the sign bit is set; where a zero's or a NaN's is, either.
    fn negative(self) -> Self::Mask;
    /// The square root, correctly rounded.
    fn sqrt(self) -> Self;

    /// `self < other`; false with NaN, as all comparisons.
    fn lt(self, other: Self) -> Self::Mask;
    /// `self <= other`.
    fn le(self, other: Self) -> Self::Mask;
    /// `self > other`.
    #[inline(always)]
    fn gt(self, other: Self) -> Self::Mask {
        other.lt(self)
    }
    /// `self >= other`.
    #[inline(always)]
    fn ge(self, other: Self) -> Self::Mask {
        other.le(self)
    }
    /// Lane by lane `if mask { yes } else { no }`.
    fn select(mask: Self::Mask, yes: Self, no: Self) -> Self;
}

/// One truth a lane.
///
/// ```
/// use intertri::lanes::Mask;
/// // One bool is a mask, too.
/// assert_eq!((bool::from_bits(0b1), true.bits(), <bool as Mask>::N), (true, 0b1, 1));
/// assert!(!(true & false).any() && (true | false).any());
/// ```
pub trait Mask: Copy + BitAnd<Output = Self> + BitOr<Output = Self> + Not<Output = Self> {
    /// How many lanes there are.
    const N: usize;

    /// Bit i is lane i; the bits above the last lane are 0.
    fn bits(self) -> u32;
    /// Lane i is bit i; the bits above the last lane do not count.
    fn from_bits(bits: u32) -> Self;
    /// Whether any lane is true.
    #[inline(always)]
    fn any(self) -> bool {
        self.bits() != 0
    }
}

/// The lane types of one level of instructions.
///
/// Only [`dispatch`] and [`Level::run`] hand one out, on a CPU that has the instructions.
///
/// ```
/// use intertri::lanes::{Ints, Lanes, Simd, WithSimd, dispatch};
/// struct Widths;
/// impl WithSimd for Widths {
///     type Output = [usize; 7];
///     fn run<S: Simd>(self) -> [usize; 7] {
///         assert!(intertri::lanes::Level::all().any(|level| level == S::LEVEL));
///         let [a, b, c] = [S::F32x4::N, S::F32x8::N, S::F32x16::N];
///         [a, b, c, S::F64x4::N, S::F64x8::N, S::I64x4::N, S::I64x8::N]
///     }
/// }
/// assert_eq!(dispatch(Widths), [4, 8, 16, 4, 8, 4, 8]);
/// ```
pub trait Simd: Copy {
    /// Four f32.
    type F32x4: Lanes<Scalar = f32>;
    /// Eight f32.
    type F32x8: Lanes<Scalar = f32>;
    /// Sixteen f32.
    type F32x16: Lanes<Scalar = f32>;
    /// Four f64.
    type F64x4: Lanes<Scalar = f64>;
    /// Eight f64.
    type F64x8: Lanes<Scalar = f64>;
    /// Four i64.
    type I64x4: Ints;
    /// Eight i64.
    type I64x8: Ints;
    /// Which level this is.
    const LEVEL: Level;

    /// Does a piece of work by a call, compiled with this level's instructions and with a frame of its own. The
    /// closure must be `#[inline(always)]`, and what it calls.
    ///
    /// ```
    /// use intertri::lanes::{Lanes, Simd, WithSimd, dispatch};
    ///
    /// struct Twice(f32);
    /// impl WithSimd for Twice {
    ///     type Output = f32;
    ///     #[inline(always)]
    ///     fn run<S: Simd>(self) -> f32 {
    ///         let mut lanes = [self.0; 8];
    ///         S::vectorize(#[inline(always)] || {
    ///             let x = S::F32x8::load(&lanes);
    ///             (x + x).store(&mut lanes);
    ///         });
    ///         lanes[7]
    ///     }
    /// }
    /// assert_eq!(dispatch(Twice(21.0)), 42.0);
    /// ```
    fn vectorize<R>(work: impl FnOnce() -> R) -> R {
        work()
    }

    /// The lanes in another order: lane i becomes what lane number `order`'s byte i, from the lowest, modulo 8, was.
    ///
    /// ```
    /// use intertri::lanes::{Lanes, Simd, WithSimd, dispatch};
    /// struct Reversed([f32; 8]);
    /// impl WithSimd for Reversed {
    ///     type Output = [f32; 8];
    ///     #[inline(always)]
    ///     fn run<S: Simd>(mut self) -> [f32; 8] {
    ///         S::permute(S::F32x8::load(&self.0), 0x00_01_02_03_04_05_06_07).store(&mut self.0);
    ///         self.0
    ///     }
    /// }
    /// let reversed = dispatch(Reversed([0.0, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0]));
    /// assert_eq!(reversed, [7.0, 6.0, 5.0, 4.0, 3.0, 2.0, 1.0, 0.0]);
    /// ```
    #[inline(always)]
    fn permute(lanes: Self::F32x8, order: u64) -> Self::F32x8 {
        let (mut from, mut to) = ([0.0; 8], [0.0; 8]);
        lanes.store(&mut from);
        for (to, lane) in to.iter_mut().zip(order.to_le_bytes()) {
            *to = from[usize::from(lane % 8)];
        }
        Lanes::load(&to)
    }

    /// The lane of the smallest number of a mask; of several that are alike but for their last three bits any, of
    /// negative ones or of none any of the eight.
    ///
    /// ```
    /// use intertri::lanes::{Lanes, Simd, WithSimd, dispatch};
    /// struct Below([f32; 8], f32);
    /// impl WithSimd for Below {
    ///     type Output = usize;
    ///     #[inline(always)]
    ///     fn run<S: Simd>(self) -> usize {
    ///         let lanes = S::F32x8::load(&self.0);
    ///         S::lane_of_least(lanes, lanes.gt(Lanes::splat(self.1)))
    ///     }
    /// }
    /// let lanes = [7.0, 0.5, 3.0, 4.0, 2.0, 9.0, 0.0, 1.0];
    /// assert_eq!([0.2, 0.7, 2.5].map(|x| dispatch(Below(lanes, x))), [1, 7, 2]);
    /// ```
    #[inline(always)]
    fn lane_of_least(lanes: Self::F32x8, mask: <Self::F32x8 as Lanes>::Mask) -> usize {
        let (mut numbers, bits) = ([0.0; 8], mask.bits());
        lanes.store(&mut numbers);
        let mut least = (u32::MAX, 0);
        for (lane, number) in numbers.iter().enumerate() {
            if bits >> lane & 1 != 0 {
                least = least.min((number.to_bits(), lane));
            }
        }
        least.1
    }

    /// Four rows of four numbers as columns.
    ///
    /// ```
    /// use intertri::lanes::{Lanes, Simd, WithSimd, dispatch};
    ///
    /// struct Turn([[f32; 4]; 4]);
    /// impl WithSimd for Turn {
    ///     type Output = [f32; 4];
    ///     #[inline(always)]
    ///     fn run<S: Simd>(self) -> [f32; 4] {
    ///         let [a, b, c, d] = &self.0;
    ///         let load = S::F32x4::load;
    ///         let mut first = [0.0; 4];
    ///         S::transpose([load(a), load(b), load(c), load(d)])[0].store(&mut first);
    ///         first
    ///     }
    /// }
    /// let row = |x| [x, 0.0, 0.0, 0.0];
    /// assert_eq!(dispatch(Turn([row(1.0), row(2.0), row(3.0), row(4.0)])), [1.0, 2.0, 3.0, 4.0]);
    /// ```
    #[inline(always)]
    fn transpose(rows: [Self::F32x4; 4]) -> [Self::F32x4; 4] {
        let mut numbers = [[0.0; 4]; 4];
        for (row, to) in rows.into_iter().zip(&mut numbers) {
            row.store(to);
        }
        let [a, b, c, d] = numbers;
        let column = |k: usize| Self::F32x4::load(&[a[k], b[k], c[k], d[k]]);
        [column(0), column(1), column(2), column(3)]
    }

    /// Sixteen rows of four numbers as columns, given by their places.
    ///
    /// ```
    /// use intertri::lanes::{Lanes, Simd, WithSimd, dispatch};
    ///
    /// struct Turn([[f32; 4]; 16]);
    /// impl WithSimd for Turn {
    ///     type Output = [f32; 16];
    ///     #[inline(always)]
    ///     fn run<S: Simd>(self) -> [f32; 16] {
    ///         let mut second = [0.0; 16];
    ///         S::columns(|i| &self.0[i])[1].store(&mut second);
    ///         second
    ///     }
    /// }
    /// let rows = core::array::from_fn(|i| [0.0, i as f32, 0.0, 0.0]);
    /// assert_eq!(dispatch(Turn(rows)), core::array::from_fn(|i| i as f32));
    /// ```
    #[inline(always)]
    fn columns<'a>(row: impl Fn(usize) -> &'a [f32; 4]) -> [Self::F32x16; 4] {
        let mut columns = [[0.0; 16]; 4];
        for i in 0..16 {
            for (column, number) in columns.iter_mut().zip(row(i)) {
                column[i] = *number;
            }
        }
        let [a, b, c, d] = &columns;
        [Lanes::load(a), Lanes::load(b), Lanes::load(c), Lanes::load(d)]
    }

    /// Eight lanes from one place and eight from another.
    ///
    /// ```
    /// use intertri::lanes::{Lanes, Simd, WithSimd, dispatch};
    ///
    /// struct Both([[f32; 8]; 2]);
    /// impl WithSimd for Both {
    ///     type Output = [f32; 16];
    ///     #[inline(always)]
    ///     fn run<S: Simd>(self) -> [f32; 16] {
    ///         let mut both = [0.0; 16];
    ///         S::halves(&self.0[0], &self.0[1]).store(&mut both);
    ///         both
    ///     }
    /// }
    /// let both = dispatch(Both([[1.0; 8], [2.0; 8]]));
    /// assert_eq!((both[..8].iter().sum(), both[8..].iter().sum()), (8.0, 16.0));
    /// ```
    #[inline(always)]
    fn halves(first: &[f32; 8], last: &[f32; 8]) -> Self::F32x16 {
        let mut both = [0.0; 16];
        both[..8].copy_from_slice(first);
        both[8..].copy_from_slice(last);
        Lanes::load(&both)
    }

    /// [`Simd::transpose`] of f64.
    ///
    /// ```
    /// use intertri::lanes::{Lanes, Simd, WithSimd, dispatch};
    ///
    /// struct Turn([[f64; 4]; 4]);
    /// impl WithSimd for Turn {
    ///     type Output = [[f64; 4]; 2];
    ///     #[inline(always)]
    ///     fn run<S: Simd>(self) -> Self::Output {
    ///         let [a, b, c, d] = &self.0;
    ///         let load = S::F64x4::load;
    ///         let [_, second, ..] = S::transpose_f64([load(a), load(b), load(c), load(d)]);
    ///         let mut out = [[0.0; 4]; 2];
    ///         second.store(&mut out[0]);
    ///         S::first_and_last(second).store(&mut out[1]);
    ///         out
    ///     }
    /// }
    /// let row = |x| [0.0, x, 0.0, 0.0];
    /// let [second, ends] = dispatch(Turn([row(1.0), row(2.0), row(3.0), row(4.0)]));
    /// assert_eq!((second, ends), ([1.0, 2.0, 3.0, 4.0], [1.0, 4.0, 4.0, 4.0]));
    /// ```
    #[inline(always)]
    fn transpose_f64(rows: [Self::F64x4; 4]) -> [Self::F64x4; 4] {
        let mut numbers = [[0.0; 4]; 4];
        for (row, to) in rows.into_iter().zip(&mut numbers) {
            row.store(to);
        }
        let [a, b, c, d] = numbers;
        let column = |k: usize| Self::F64x4::load(&[a[k], b[k], c[k], d[k]]);
        [column(0), column(1), column(2), column(3)]
    }

    /// The first lane, and then the last one three times.
    #[inline(always)]
    fn first_and_last(lanes: Self::F64x4) -> Self::F64x4 {
        let mut numbers = [0.0; 4];
        lanes.store(&mut numbers);
        let [first, .., last] = numbers;
        Self::F64x4::load(&[first, last, last, last])
    }
}

/// [`Lanes::mul_error`] where nothing is fused: with halves of the factors, whose products are exact.
/// `split` is two to half of a number's digits, rounded up, and one.
///
/// Dekker, A Floating-Point Technique for Extending the Available Precision, 1971.
#[inline(always)]
fn mul_error<L: Lanes>(a: L, b: L, product: L, split: L) -> L {
    let (by_a, by_b) = (a * split, b * split);
    let (a_high, b_high) = (by_a - (by_a - a), by_b - (by_b - b));
    let (a_low, b_low) = (a - a_high, b - b_high);
    a_low * b_low - (((product - a_high * b_high) - a_low * b_high) - a_high * b_low)
}

#[cfg(test)]
mod tests;
