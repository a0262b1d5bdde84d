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
pub use level::{Level, WithSimd, dispatch, prefetch};
pub(crate) use pair::Pair;

/// N numbers side by side, f32 or f64.
///
/// `+ - * /`, negation, [`Lanes::abs`], [`Lanes::sqrt`] and comparisons are IEEE 754's, lane by lane
/// and correctly rounded, the same at every level; they are never fused or reassociated. Only
/// [`Lanes::mul_add`] may round once or twice.
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
    /// The larger; where one is NaN, either.
    fn max(self, other: Self) -> Self;
    /// The smaller; where one is NaN, either.
    fn min(self, other: Self) -> Self;
    /// Without its sign.
    fn abs(self) -> Self;
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

    /// The lanes in another order: lane i becomes what lane number `order`'s byte i, from the lowest, modulo 8, was.
    #[inline(always)]
    fn permute(lanes: Self::F32x8, order: u64) -> Self::F32x8 {
        let (mut from, mut to) = ([0.0; 8], [0.0; 8]);
        lanes.store(&mut from);
        for (to, lane) in to.iter_mut().zip(order.to_le_bytes()) {
            *to = from[usize::from(lane % 8)];
        }
        Lanes::load(&to)
    }

    /// Four rows of four numbers as columns.
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
}

#[cfg(test)]
mod tests;
