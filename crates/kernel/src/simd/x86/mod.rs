//! Lane types for AVX2 and AVX-512.
//!
//! The `SAFETY` argument in the module comment of [`reg`] also applies to this module.
#![allow(unsafe_code, clippy::wildcard_imports)]

mod int;
mod reg;
mod shuffle;

use core::arch::x86_64::*;

use super::lanes::Lanes;
use super::level::Level;
use super::level_lanes::Simd;
use super::pair::Pair;
use reg::Reg;
use shuffle::{
    eight_as_columns, first_and_last, lane_of_least, permute, sixteen_as_columns, transpose,
    transpose_f64,
};

/// Implements [`Simd::vectorize`] with a level's instructions. The call is sound because code that
/// can name the level's type already runs inside [`Level::run`] or inside this function.
macro_rules! vectorize {
    ($features:literal) => {
        #[inline(always)]
        fn vectorize<R>(work: impl FnOnce() -> R) -> R {
            #[target_feature(enable = $features)]
            fn with_features<R>(work: impl FnOnce() -> R) -> R {
                work()
            }
            cpu!(with_features(work))
        }
    };
}

/// The AVX2 level, with 256-bit registers.
#[derive(Clone, Copy)]
pub(super) struct Avx2;

impl Simd for Avx2 {
    type F32x4 = Reg<__m128>;
    type F32x8 = Reg<__m256>;
    type F32x16 = Pair<Reg<__m256>>;
    type F64x4 = Reg<__m256d>;
    type F64x8 = Pair<Reg<__m256d>>;
    type I64x8 = Pair<Reg<__m256i>>;
    type WideInts = Self::I64x8;
    type F32s = Self::F32x8;
    type F64s = Self::F64x8;
    const LEVEL: Level = Level::AVX2;

    vectorize!("avx2,fma,bmi1,bmi2,lzcnt,popcnt");

    #[inline(always)]
    fn permute(lanes: Self::F32x8, order: u64) -> Self::F32x8 {
        Reg(cpu!(permute(lanes.0, order)))
    }
    #[inline(always)]
    fn lane_of_least(lanes: Self::F32x8, mask: <Self::F32x8 as Lanes>::Mask) -> usize {
        cpu!(lane_of_least(lanes.0, mask.0))
    }
    #[inline(always)]
    fn transpose(rows: [Self::F32x4; 4]) -> [Self::F32x4; 4] {
        transpose(rows)
    }
    #[inline(always)]
    fn columns<'a>(row: impl Fn(usize) -> &'a [f32; 4]) -> [Self::F32x16; 4] {
        let [a, b, c, d] = eight_as_columns(&row);
        let [e, f, g, h] = eight_as_columns(|i| row(8 + i));
        [Pair(a, e), Pair(b, f), Pair(c, g), Pair(d, h)]
    }
    #[inline(always)]
    fn register_columns<'a>(row: impl Fn(usize) -> &'a [f32; 4]) -> [Self::F32x8; 4] {
        eight_as_columns(row)
    }
    #[inline(always)]
    fn halves(first: &[f32; 8], last: &[f32; 8]) -> Self::F32x16 {
        Pair(Lanes::load(first), Lanes::load(last))
    }
    #[inline(always)]
    fn transpose_f64(rows: [Self::F64x4; 4]) -> [Self::F64x4; 4] {
        transpose_f64(rows)
    }
    #[inline(always)]
    fn first_and_last(lanes: Self::F64x4) -> Self::F64x4 {
        Reg(cpu!(first_and_last(lanes.0)))
    }
}

/// The AVX-512 level. It uses 512-bit registers, and narrower ones for fewer lanes.
#[derive(Clone, Copy)]
pub(super) struct Avx512;

impl Simd for Avx512 {
    type F32x4 = Reg<__m128>;
    type F32x8 = Reg<__m256>;
    type F32x16 = Reg<__m512>;
    type F64x4 = Reg<__m256d>;
    type F64x8 = Reg<__m512d>;
    type I64x8 = Reg<__m512i>;
    type WideInts = int::Long;
    type F32s = Self::F32x16;
    type F64s = Pair<Self::F64x8>;
    const LEVEL: Level = Level::AVX512;

    vectorize!("avx512f,avx512bw,avx512cd,avx512dq,avx512vl,avx2,fma,bmi1,bmi2,lzcnt,popcnt");

    #[inline(always)]
    fn permute(lanes: Self::F32x8, order: u64) -> Self::F32x8 {
        Reg(cpu!(permute(lanes.0, order)))
    }
    #[inline(always)]
    fn lane_of_least(lanes: Self::F32x8, mask: <Self::F32x8 as Lanes>::Mask) -> usize {
        cpu!(lane_of_least(lanes.0, mask.0))
    }
    #[inline(always)]
    fn transpose(rows: [Self::F32x4; 4]) -> [Self::F32x4; 4] {
        transpose(rows)
    }
    #[inline(always)]
    fn columns<'a>(row: impl Fn(usize) -> &'a [f32; 4]) -> [Self::F32x16; 4] {
        sixteen_as_columns(row)
    }
    #[inline(always)]
    fn register_columns<'a>(row: impl Fn(usize) -> &'a [f32; 4]) -> [Self::F32x16; 4] {
        sixteen_as_columns(row)
    }
    #[inline(always)]
    fn halves(first: &[f32; 8], last: &[f32; 8]) -> Self::F32x16 {
        let (first, last) = (Reg::<__m256>::load(first), Reg::<__m256>::load(last));
        // The cast is free. It leaves the upper half undefined, but the insertion then overwrites
        // that half.
        Reg(cpu!(_mm512_insertf32x8::<1>(_mm512_castps256_ps512(first.0), last.0)))
    }
    #[inline(always)]
    fn transpose_f64(rows: [Self::F64x4; 4]) -> [Self::F64x4; 4] {
        transpose_f64(rows)
    }
    #[inline(always)]
    fn first_and_last(lanes: Self::F64x4) -> Self::F64x4 {
        Reg(cpu!(first_and_last(lanes.0)))
    }
}
