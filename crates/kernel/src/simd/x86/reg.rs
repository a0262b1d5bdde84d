//! AVX2 and AVX-512 registers, as implementations of [`Lanes`] and [`Mask`].
//!
//! `wide` chooses its instructions at compile time. These types use the CPU's instructions even in
//! a build for a generic target. They are private to `simd`: a value exists only inside
//! [`Level::run`](crate::simd::Level::run), which has verified that the CPU supports them. This is
//! the `SAFETY` argument for every call below. Loads and stores also stay in bounds: each accesses
//! the N elements of a slice just cut to length N.
#![allow(unsafe_code, clippy::wildcard_imports)]

use core::arch::x86_64::*;
use core::ops::{Add, BitAnd, BitOr, Div, Mul, Neg, Not, Sub};

use super::super::lanes::{Lanes, Mask};

/// A register that holds one value per lane.
#[derive(Clone, Copy)]
pub(in crate::simd) struct Reg<T>(pub(super) T);

/// A mask register in which only each lane's sign bit matters, as AVX2 expects.
#[derive(Clone, Copy)]
pub(in crate::simd) struct Ones<T>(pub(super) T);

/// An AVX-512 mask register.
#[derive(Clone, Copy)]
pub(in crate::simd) struct Bits<T>(T);

macro_rules! operator {
    ($t:ty, $op:ident $f:ident $intrinsic:ident) => {
        impl $op for $t {
            type Output = Self;
            #[inline(always)]
            fn $f(self, b: Self) -> Self {
                Self(cpu!($intrinsic(self.0, b.0)))
            }
        }
    };
}

/// Implements the operations that AVX2 and AVX-512 registers share. Comparison, selection, and
/// loads are parameters.
macro_rules! lanes {
    (
        $reg:ty, $scalar:ty, $n:literal, mask $mask:ty,
        $add:ident $sub:ident $mul:ident $div:ident $fma:ident $min:ident $max:ident $sqrt:ident
        $xor:ident $or:ident $and:ident $andnot:ident $set1:ident $loadu:ident $storeu:ident,
        load_f32 $load_f32:expr, store_f32 $store_f32:expr, compare $compare:ident, negative $negative:expr, blend $blend:expr
    ) => {
        operator!(Reg<$reg>, Add add $add);
        operator!(Reg<$reg>, Sub sub $sub);
        operator!(Reg<$reg>, Mul mul $mul);
        operator!(Reg<$reg>, Div div $div);

        impl Neg for Reg<$reg> {
            type Output = Self;
            #[inline(always)]
            fn neg(self) -> Self {
                // Toggle the sign bit: `0 - x` would turn 0 into 0, not into -0.
                Self(cpu!($xor(self.0, $set1(-0.0))))
            }
        }

        impl Lanes for Reg<$reg> {
            type Scalar = $scalar;
            type Mask = $mask;
            const N: usize = $n;

            #[inline(always)]
            fn splat(x: $scalar) -> Self {
                Self(cpu!($set1(x)))
            }
            #[inline(always)]
            fn load(from: &[$scalar]) -> Self {
                let from = from[..$n].as_ptr();
                Self(cpu!($loadu(from)))
            }
            #[inline(always)]
            fn load_f32(from: &[f32]) -> Self {
                let from = from[..$n].as_ptr();
                Self(cpu!($load_f32(from)))
            }
            #[inline(always)]
            fn store(self, to: &mut [$scalar]) {
                let to = to[..$n].as_mut_ptr();
                cpu!($storeu(to, self.0));
            }
            #[inline(always)]
            fn store_f32(self, to: &mut [f32]) {
                let to = to[..$n].as_mut_ptr();
                cpu!($store_f32(to, self.0));
            }
            #[inline(always)]
            fn mul_add(self, b: Self, c: Self) -> Self {
                Self(cpu!($fma(self.0, b.0, c.0)))
            }
            #[inline(always)]
            fn mul_error(self, b: Self, product: Self) -> Self {
                // The multiply-add rounds once, and the error of a product fits in the same format,
                // so the result is exact.
                self.mul_add(b, -product)
            }
            #[inline(always)]
            fn max(self, other: Self) -> Self {
                Self(cpu!($max(self.0, other.0)))
            }
            #[inline(always)]
            fn min(self, other: Self) -> Self {
                Self(cpu!($min(self.0, other.0)))
            }
            #[inline(always)]
            fn abs(self) -> Self {
                Self(cpu!($andnot($set1(-0.0), self.0)))
            }
            #[inline(always)]
            fn power(self) -> Self {
                // Infinity has exactly the exponent bits set, so the bitwise AND clears the sign
                // and the fraction and leaves a power of two.
                Self(cpu!($and(self.0, $set1(<$scalar>::INFINITY))))
            }
            #[inline(always)]
            fn flip(self, of: Self) -> Self {
                Self(cpu!($xor(self.0, $and(of.0, $set1(-0.0)))))
            }
            #[inline(always)]
            fn or_sign(self, other: Self) -> Self {
                Self(cpu!($or(self.0, other.0)))
            }
            #[inline(always)]
            fn negative(self) -> $mask {
                <$mask>::new($negative(self.0))
            }
            #[inline(always)]
            fn sqrt(self) -> Self {
                Self(cpu!($sqrt(self.0)))
            }
            #[inline(always)]
            fn lt(self, other: Self) -> $mask {
                // "OQ" means ordered (false for NaN) and quiet (raises no exception).
                <$mask>::new(cpu!($compare::<_CMP_LT_OQ>(self.0, other.0)))
            }
            #[inline(always)]
            fn le(self, other: Self) -> $mask {
                <$mask>::new(cpu!($compare::<_CMP_LE_OQ>(self.0, other.0)))
            }
            #[inline(always)]
            fn select(mask: $mask, yes: Self, no: Self) -> Self {
                Self(cpu!($blend(mask.0, yes.0, no.0)))
            }
        }
    };
}

/// Implements masks that are as wide as the registers to which they apply, as in AVX2.
macro_rules! ones {
    ($reg:ty, $n:literal, $and:ident $or:ident $xor:ident $movemask:ident, $all:expr, $spread:expr) => {
        operator!(Ones<$reg>, BitAnd bitand $and);
        operator!(Ones<$reg>, BitOr bitor $or);

        impl Not for Ones<$reg> {
            type Output = Self;
            #[inline(always)]
            fn not(self) -> Self {
                Self(cpu!($xor(self.0, $all)))
            }
        }

        impl Ones<$reg> {
            #[inline(always)]
            fn new(mask: $reg) -> Self {
                Self(mask)
            }
        }

        impl Mask for Ones<$reg> {
            const N: usize = $n;

            #[inline(always)]
            fn bits(self) -> u32 {
                cpu!($movemask(self.0)) as u32
            }
            #[inline(always)]
            fn from_bits(bits: u32) -> Self {
                Self(cpu!($spread(bits as i32)))
            }
        }
    };
}

ones!(__m128, 4, _mm_and_ps _mm_or_ps _mm_xor_ps _mm_movemask_ps,
_mm_castsi128_ps(_mm_set1_epi32(-1)), spread_4);
ones!(__m256, 8, _mm256_and_ps _mm256_or_ps _mm256_xor_ps _mm256_movemask_ps,
_mm256_castsi256_ps(_mm256_set1_epi32(-1)), spread_8);
ones!(__m256d, 4, _mm256_and_pd _mm256_or_pd _mm256_xor_pd _mm256_movemask_pd,
_mm256_castsi256_pd(_mm256_set1_epi64x(-1)), spread_4_wide);

// The following functions convert bits to masks. Closures in their place might be compiled without
// the level's instructions.

#[inline]
#[target_feature(enable = "avx2")]
fn spread_4(bits: i32) -> __m128 {
    // Copy all bits to every lane, then clear all but the lane's own bit. The comparison sets all
    // bits of each lane whose own bit is set.
    let bit = _mm_setr_epi32(1, 2, 4, 8);
    _mm_castsi128_ps(_mm_cmpeq_epi32(_mm_and_si128(_mm_set1_epi32(bits), bit), bit))
}

#[inline]
#[target_feature(enable = "avx2")]
fn spread_8(bits: i32) -> __m256 {
    let bit = _mm256_setr_epi32(1, 2, 4, 8, 16, 32, 64, 128);
    _mm256_castsi256_ps(_mm256_cmpeq_epi32(_mm256_and_si256(_mm256_set1_epi32(bits), bit), bit))
}

#[inline]
#[target_feature(enable = "avx2")]
fn spread_4_wide(bits: i32) -> __m256d {
    let bit = _mm256_setr_epi64x(1, 2, 4, 8);
    let bits = _mm256_set1_epi64x(i64::from(bits));
    _mm256_castsi256_pd(_mm256_cmpeq_epi64(_mm256_and_si256(bits, bit), bit))
}

// AVX blends and `movemask` use only the sign bits, so `negative` returns its operand unchanged.
lanes!(__m128, f32, 4, mask Ones<__m128>,
    _mm_add_ps _mm_sub_ps _mm_mul_ps _mm_div_ps _mm_fmadd_ps _mm_min_ps _mm_max_ps _mm_sqrt_ps
    _mm_xor_ps _mm_or_ps _mm_and_ps _mm_andnot_ps _mm_set1_ps _mm_loadu_ps _mm_storeu_ps,
    load_f32 _mm_loadu_ps, store_f32 _mm_storeu_ps, compare _mm_cmp_ps, negative |x| x, blend |m, yes, no| _mm_blendv_ps(no, yes, m));
lanes!(__m256, f32, 8, mask Ones<__m256>,
    _mm256_add_ps _mm256_sub_ps _mm256_mul_ps _mm256_div_ps _mm256_fmadd_ps _mm256_min_ps
    _mm256_max_ps _mm256_sqrt_ps
    _mm256_xor_ps _mm256_or_ps _mm256_and_ps _mm256_andnot_ps _mm256_set1_ps _mm256_loadu_ps _mm256_storeu_ps,
    load_f32 _mm256_loadu_ps, store_f32 _mm256_storeu_ps, compare _mm256_cmp_ps, negative |x| x,
    blend |m, yes, no| _mm256_blendv_ps(no, yes, m));
lanes!(__m256d, f64, 4, mask Ones<__m256d>,
    _mm256_add_pd _mm256_sub_pd _mm256_mul_pd _mm256_div_pd _mm256_fmadd_pd _mm256_min_pd
    _mm256_max_pd _mm256_sqrt_pd
    _mm256_xor_pd _mm256_or_pd _mm256_and_pd _mm256_andnot_pd _mm256_set1_pd _mm256_loadu_pd _mm256_storeu_pd,
    load_f32 |from| _mm256_cvtps_pd(_mm_loadu_ps(from)), store_f32 |to, x| _mm_storeu_ps(to, _mm256_cvtpd_ps(x)), compare _mm256_cmp_pd, negative |x| x,
    blend |m, yes, no| _mm256_blendv_pd(no, yes, m));
lanes!(__m512, f32, 16, mask Bits<__mmask16>,
    _mm512_add_ps _mm512_sub_ps _mm512_mul_ps _mm512_div_ps _mm512_fmadd_ps _mm512_min_ps
    _mm512_max_ps _mm512_sqrt_ps
    _mm512_xor_ps _mm512_or_ps _mm512_and_ps _mm512_andnot_ps _mm512_set1_ps _mm512_loadu_ps _mm512_storeu_ps,
    load_f32 _mm512_loadu_ps, store_f32 _mm512_storeu_ps, compare _mm512_cmp_ps_mask, negative |x| cpu!(_mm512_movepi32_mask(_mm512_castps_si512(x))),
    blend |m, yes, no| _mm512_mask_blend_ps(m, no, yes));
lanes!(__m512d, f64, 8, mask Bits<__mmask8>,
    _mm512_add_pd _mm512_sub_pd _mm512_mul_pd _mm512_div_pd _mm512_fmadd_pd _mm512_min_pd
    _mm512_max_pd _mm512_sqrt_pd
    _mm512_xor_pd _mm512_or_pd _mm512_and_pd _mm512_andnot_pd _mm512_set1_pd _mm512_loadu_pd _mm512_storeu_pd,
    load_f32 |from| _mm512_cvtps_pd(_mm256_loadu_ps(from)), store_f32 |to, x| _mm256_storeu_ps(to, _mm512_cvtpd_ps(x)), compare _mm512_cmp_pd_mask, negative |x| cpu!(_mm512_movepi64_mask(_mm512_castpd_si512(x))),
    blend |m, yes, no| _mm512_mask_blend_pd(m, no, yes));

/// Implements masks with one bit per lane.
macro_rules! bits {
    ($bits:ty, $n:literal) => {
        impl BitAnd for Bits<$bits> {
            type Output = Self;
            #[inline(always)]
            fn bitand(self, b: Self) -> Self {
                Self(self.0 & b.0)
            }
        }
        impl BitOr for Bits<$bits> {
            type Output = Self;
            #[inline(always)]
            fn bitor(self, b: Self) -> Self {
                Self(self.0 | b.0)
            }
        }
        impl Not for Bits<$bits> {
            type Output = Self;
            #[inline(always)]
            fn not(self) -> Self {
                Self(!self.0)
            }
        }
        impl Bits<$bits> {
            #[inline(always)]
            fn new(mask: $bits) -> Self {
                Self(mask)
            }
        }
        impl Mask for Bits<$bits> {
            const N: usize = $n;

            #[inline(always)]
            fn bits(self) -> u32 {
                u32::from(self.0)
            }
            #[inline(always)]
            fn from_bits(bits: u32) -> Self {
                Self(bits as $bits)
            }
        }
    };
}
bits!(__mmask16, 16);
bits!(__mmask8, 8);
