//! Integer lanes for AVX2 and AVX-512.
//!
//! The `SAFETY` argument in the module comment of [`super::reg`] also applies to this module.
#![allow(unsafe_code, clippy::wildcard_imports)]

use core::arch::x86_64::*;
use core::ops::{Add, Sub};

use super::super::int::Ints;
use super::reg::Reg;

macro_rules! ints {
    (
        $reg:ty, $n:literal, $add:ident $sub:ident $set1:ident $loadu:ident $storeu:ident,
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
            fn store(self, to: &mut [i64]) {
                let to = to[..$n].as_mut_ptr().cast();
                cpu!($storeu(to, self.0));
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
    _mm256_loadu_si256 _mm256_storeu_si256,
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
    _mm512_loadu_si512 _mm512_storeu_si512,
    {
        #[inline(always)]
        fn times(self, b: Self) -> Self {
            Self(cpu!(_mm512_mullo_epi64(self.0, b.0)))
        }
    },
    negative |x| _mm512_movepi64_mask(x),
    zero |x| _mm512_testn_epi64_mask(x, x));
