//! Lanes based on the vectors of the `wide` crate, which uses SSE2, NEON, WebAssembly's simd128, or
//! other instructions, depending on the build.

use core::ops::{Add, BitAnd, BitOr, Div, Mul, Neg, Not, Sub};

use super::lanes::{Lanes, Mask, mul_error};
use super::level::Level;
use super::level_lanes::Simd;

/// A vector of `wide`, or the mask that results from comparing two vectors.
#[derive(Clone, Copy)]
pub(super) struct V<T>(T);

macro_rules! lanes {
    ($t:ty, $scalar:ty, $n:literal, $load_f32:expr) => {
        impl Add for V<$t> {
            type Output = Self;
            #[inline(always)]
            fn add(self, b: Self) -> Self {
                Self(self.0 + b.0)
            }
        }
        impl Sub for V<$t> {
            type Output = Self;
            #[inline(always)]
            fn sub(self, b: Self) -> Self {
                Self(self.0 - b.0)
            }
        }
        impl Mul for V<$t> {
            type Output = Self;
            #[inline(always)]
            fn mul(self, b: Self) -> Self {
                Self(self.0 * b.0)
            }
        }
        impl Div for V<$t> {
            type Output = Self;
            #[inline(always)]
            fn div(self, b: Self) -> Self {
                Self(self.0 / b.0)
            }
        }
        impl Neg for V<$t> {
            type Output = Self;
            #[inline(always)]
            fn neg(self) -> Self {
                Self(self.0 ^ <$t>::splat(-0.0))
            }
        }
        impl BitAnd for V<$t> {
            type Output = Self;
            #[inline(always)]
            fn bitand(self, b: Self) -> Self {
                Self(self.0 & b.0)
            }
        }
        impl BitOr for V<$t> {
            type Output = Self;
            #[inline(always)]
            fn bitor(self, b: Self) -> Self {
                Self(self.0 | b.0)
            }
        }
        impl Not for V<$t> {
            type Output = Self;
            #[inline(always)]
            fn not(self) -> Self {
                Self(!self.0)
            }
        }

        impl Mask for V<$t> {
            const N: usize = $n;

            #[inline(always)]
            fn bits(self) -> u32 {
                self.0.to_bitmask() as u32
            }
            #[inline(always)]
            fn from_bits(bits: u32) -> Self {
                // `wide` cannot create a mask from bits, so compare 0 with 0 or 1 in each lane.
                let lane = |i: usize| if bits >> i & 1 != 0 { 1.0 } else { 0.0 };
                Self(<$t>::splat(0.0).simd_lt(<$t>::new(core::array::from_fn(lane))))
            }
        }

        impl Lanes for V<$t> {
            type Scalar = $scalar;
            type Mask = Self;
            const N: usize = $n;

            #[inline(always)]
            fn splat(x: $scalar) -> Self {
                Self(<$t>::splat(x))
            }
            #[inline(always)]
            fn load(from: &[$scalar]) -> Self {
                let from: [$scalar; $n] = from[..$n].try_into().expect("the slice has N elements");
                Self(<$t>::new(from))
            }
            #[inline(always)]
            fn load_f32(from: &[f32]) -> Self {
                let from: [f32; $n] = from[..$n].try_into().expect("the slice has N elements");
                Self(<$t>::new(from.map($load_f32)))
            }
            #[inline(always)]
            fn store(self, to: &mut [$scalar]) {
                to[..$n].copy_from_slice(&self.0.to_array());
            }
            #[inline(always)]
            fn store_f32(self, to: &mut [f32]) {
                to[..$n].copy_from_slice(&self.0.to_array().map(|x| x as f32));
            }
            #[inline(always)]
            fn mul_add(self, b: Self, c: Self) -> Self {
                Self(self.0.mul_add(b.0, c.0))
            }
            #[inline(always)]
            fn mul_error(self, b: Self, product: Self) -> Self {
                // The split factor: two to the power of half the digits (rounded up), plus one.
                const SPLIT: $scalar =
                    ((1 << <$scalar>::MANTISSA_DIGITS.div_ceil(2)) + 1) as $scalar;
                mul_error(self, b, product, Self::splat(SPLIT))
            }
            #[inline(always)]
            fn max(self, other: Self) -> Self {
                Self(self.0.fast_max(other.0))
            }
            #[inline(always)]
            fn min(self, other: Self) -> Self {
                Self(self.0.fast_min(other.0))
            }
            #[inline(always)]
            fn abs(self) -> Self {
                Self(self.0.abs())
            }
            #[inline(always)]
            fn power(self) -> Self {
                // Infinity has only the exponent bits set, so this mask clears the sign and the
                // fraction and leaves a power of two.
                Self(self.0 & <$t>::splat(<$scalar>::INFINITY))
            }
            #[inline(always)]
            fn flip(self, of: Self) -> Self {
                Self(self.0 ^ (of.0 & <$t>::splat(-0.0)))
            }
            #[inline(always)]
            fn or_sign(self, other: Self) -> Self {
                // Do not combine the bits: the result may be a NaN, which is not less than 0.
                Self(self.0.fast_min(other.0))
            }
            #[inline(always)]
            fn negative(self) -> Self {
                // The masks of `wide` set or clear all bits of a lane.
                Self(self.0.simd_lt(<$t>::splat(0.0)))
            }
            #[inline(always)]
            fn sqrt(self) -> Self {
                Self(self.0.sqrt())
            }
            #[inline(always)]
            fn lt(self, other: Self) -> Self {
                Self(self.0.simd_lt(other.0))
            }
            #[inline(always)]
            fn le(self, other: Self) -> Self {
                Self(self.0.simd_le(other.0))
            }
            #[inline(always)]
            fn select(mask: Self, yes: Self, no: Self) -> Self {
                Self(mask.0.bitselect(yes.0, no.0))
            }
        }
    };
}

lanes!(::wide::f32x4, f32, 4, |x| x);
lanes!(::wide::f32x8, f32, 8, |x| x);
lanes!(::wide::f32x16, f32, 16, |x| x);
lanes!(::wide::f64x4, f64, 4, f64::from);
lanes!(::wide::f64x8, f64, 8, f64::from);

/// The level that every CPU supports.
#[derive(Clone, Copy)]
pub(super) struct Baseline;

impl Simd for Baseline {
    type F32x4 = V<::wide::f32x4>;
    type F32x8 = V<::wide::f32x8>;
    type F32x16 = V<::wide::f32x16>;
    type F64x4 = V<::wide::f64x4>;
    type F64x8 = V<::wide::f64x8>;
    type I64x8 = ::wide::i64x8;
    type WideInts = Self::I64x8;
    type F32s = registers::F32s;
    type F64s = registers::F64s;
    const LEVEL: Level = Level::PORTABLE;

    #[inline(always)]
    fn register_columns<'a>(row: impl Fn(usize) -> &'a [f32; 4]) -> [Self::F32s; 4] {
        registers::columns(row)
    }
}

/// Four lanes, on targets for which `wide` has registers.
#[cfg(any(target_feature = "sse2", target_feature = "neon", target_feature = "simd128"))]
mod registers {
    use super::V;

    pub(super) type F32s = V<::wide::f32x4>;
    pub(super) type F64s = V<::wide::f64x4>;

    #[inline(always)]
    pub(super) fn columns<'a>(row: impl Fn(usize) -> &'a [f32; 4]) -> [F32s; 4] {
        let load = |i: usize| ::wide::f32x4::new(*row(i));
        let [a, b, c, d] = ::wide::f32x4::transpose([load(0), load(1), load(2), load(3)]);
        [V(a), V(b), V(c), V(d)]
    }
}

/// One lane: without SIMD registers, wider lanes would only be moved to memory and back.
#[cfg(not(any(target_feature = "sse2", target_feature = "neon", target_feature = "simd128")))]
mod registers {
    pub(super) type F32s = f32;
    pub(super) type F64s = f64;

    #[inline(always)]
    pub(super) fn columns<'a>(row: impl Fn(usize) -> &'a [f32; 4]) -> [F32s; 4] {
        *row(0)
    }
}
