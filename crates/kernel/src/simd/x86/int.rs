//! Integer lanes for AVX2 and AVX-512.
//!
//! The `SAFETY` argument in the module comment of [`super::reg`] also applies to this module.
#![allow(unsafe_code, clippy::wildcard_imports)]

use core::arch::x86_64::*;
use core::ops::{Add, Sub};

use super::super::int::{Ints, shifted};
use super::reg::Reg;

macro_rules! ints {
    (
        $reg:ty, $n:literal, $add:ident $sub:ident $set1:ident $loadu:ident,
        {$($times:tt)*}, negative $negative:expr, zero $zero:expr
    ) => {
        impl Add for Reg<$reg> {
            type Output = Self;
            #[inline(always)]
            fn add(self, b: Self) -> Self {
                Self(cpu!($add(self.0, b.0)))
            }
        }
        impl Sub for Reg<$reg> {
            type Output = Self;
            #[inline(always)]
            fn sub(self, b: Self) -> Self {
                Self(cpu!($sub(self.0, b.0)))
            }
        }
        impl Ints for Reg<$reg> {
            const N: usize = $n;
            const BITS: u32 = 64;

            #[inline(always)]
            fn splat(x: i64) -> Self {
                Self(cpu!($set1(x)))
            }
            #[inline(always)]
            fn load(from: &[i64]) -> Self {
                let from = from[..$n].as_ptr().cast();
                Self(cpu!($loadu(from)))
            }
            #[inline(always)]
            fn shifted(from: &[i64], exponents: &[i64]) -> Self {
                Self::load(&shifted::<$n>(from, exponents))
            }
            $($times)*
            #[inline(always)]
            fn negative(self) -> u32 {
                cpu!($negative(self.0)) as u32
            }
            #[inline(always)]
            fn zero(self) -> u32 {
                cpu!($zero(self.0)) as u32
            }
        }
    };
}

ints!(__m256i, 4, _mm256_add_epi64 _mm256_sub_epi64 _mm256_set1_epi64x
    _mm256_loadu_si256,
    {
        /// Adds the products of the unsigned halves that reach the lower 64 bits.
        #[inline(always)]
        fn times(self, b: Self) -> Self {
            let (a_high, b_high) = cpu!((_mm256_srli_epi64::<32>(self.0), _mm256_srli_epi64::<32>(b.0)));
            let low = Self(cpu!(_mm256_mul_epu32(self.0, b.0)));
            let x = Self(cpu!(_mm256_mul_epu32(a_high, b.0)));
            let y = Self(cpu!(_mm256_mul_epu32(self.0, b_high)));
            low + Self(cpu!(_mm256_slli_epi64::<32>((x + y).0)))
        }
    },
    negative |x| _mm256_movemask_pd(_mm256_castsi256_pd(x)),
    zero |x| _mm256_movemask_pd(_mm256_castsi256_pd(
        _mm256_cmpeq_epi64(x, _mm256_setzero_si256()))));
ints!(__m512i, 8, _mm512_add_epi64 _mm512_sub_epi64 _mm512_set1_epi64
    _mm512_loadu_si512,
    {
        #[inline(always)]
        fn times(self, b: Self) -> Self {
            Self(cpu!(_mm512_mullo_epi64(self.0, b.0)))
        }
    },
    negative |x| _mm512_movepi64_mask(x),
    zero |x| _mm512_testn_epi64_mask(x, x));

/// Eight 128-bit integers: the lower and the upper halves of their digits.
#[derive(Clone, Copy)]
pub(in crate::simd) struct Long(__m512i, __m512i);

impl Add for Long {
    type Output = Self;
    #[inline(always)]
    fn add(self, b: Self) -> Self {
        cpu!({
            let low = _mm512_add_epi64(self.0, b.0);
            let high = _mm512_add_epi64(self.1, b.1);
            let carry = _mm512_cmplt_epu64_mask(low, b.0);
            Self(low, _mm512_mask_add_epi64(high, carry, high, _mm512_set1_epi64(1)))
        })
    }
}

impl Sub for Long {
    type Output = Self;
    #[inline(always)]
    fn sub(self, b: Self) -> Self {
        cpu!({
            let high = _mm512_sub_epi64(self.1, b.1);
            let borrow = _mm512_cmplt_epu64_mask(self.0, b.0);
            let high = _mm512_mask_sub_epi64(high, borrow, high, _mm512_set1_epi64(1));
            Self(_mm512_sub_epi64(self.0, b.0), high)
        })
    }
}

impl Ints for Long {
    const N: usize = 8;
    const BITS: u32 = 128;

    #[inline(always)]
    fn splat(x: i64) -> Self {
        Self(cpu!(_mm512_set1_epi64(x)), cpu!(_mm512_set1_epi64(x >> 63)))
    }
    #[inline(always)]
    fn load(from: &[i64]) -> Self {
        let Reg(low) = Reg::<__m512i>::load(from);
        Self(low, cpu!(_mm512_srai_epi64::<63>(low)))
    }
    #[inline(always)]
    fn shifted(from: &[i64], exponents: &[i64]) -> Self {
        let (Reg(x), Reg(by)) = (Reg::<__m512i>::load(from), Reg::<__m512i>::load(exponents));
        cpu!({
            // Shifts by 64 or more digits, or by a negative number, result in 0 or the sign.
            let limb = _mm512_set1_epi64(64);
            let crossing = _mm512_srav_epi64(x, _mm512_sub_epi64(limb, by));
            let beyond = _mm512_sllv_epi64(x, _mm512_sub_epi64(by, limb));
            let is_beyond = _mm512_cmpge_epi64_mask(by, limb);
            Self(_mm512_sllv_epi64(x, by), _mm512_mask_mov_epi64(crossing, is_beyond, beyond))
        })
    }
    /// Adds the products of the unsigned halves of the lower digits, and the products of the lower
    /// digits with the upper ones.
    #[inline(always)]
    fn times(self, b: Self) -> Self {
        let Self(a_low, a_high) = self;
        let Self(b_low, b_high) = b;
        cpu!({
            let (a1, b1) = (_mm512_srli_epi64::<32>(a_low), _mm512_srli_epi64::<32>(b_low));
            let (p00, p01) = (_mm512_mul_epu32(a_low, b_low), _mm512_mul_epu32(a_low, b1));
            let (p10, p11) = (_mm512_mul_epu32(a1, b_low), _mm512_mul_epu32(a1, b1));
            // Neither sum overflows: a product of two 32-bit numbers leaves room for two such numbers.
            let half = _mm512_set1_epi64(u32::MAX as i64);
            let middle = _mm512_add_epi64(p01, _mm512_srli_epi64::<32>(p00));
            let other = _mm512_add_epi64(p10, _mm512_and_si512(middle, half));
            let low = _mm512_or_si512(_mm512_slli_epi64::<32>(other), _mm512_and_si512(p00, half));
            let carries =
                _mm512_add_epi64(_mm512_srli_epi64::<32>(middle), _mm512_srli_epi64::<32>(other));
            let across = _mm512_add_epi64(
                _mm512_mullo_epi64(a_low, b_high),
                _mm512_mullo_epi64(a_high, b_low),
            );
            Self(low, _mm512_add_epi64(_mm512_add_epi64(p11, carries), across))
        })
    }
    #[inline(always)]
    fn negative(self) -> u32 {
        Reg(self.1).negative()
    }
    #[inline(always)]
    fn zero(self) -> u32 {
        Reg(cpu!(_mm512_or_si512(self.0, self.1))).zero()
    }
}
