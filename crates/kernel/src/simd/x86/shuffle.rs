//! Operations across AVX2 and AVX-512 lanes: permutations, minima, and transpositions.
//!
//! The `SAFETY` argument in the module comment of [`super::reg`] also applies to this module.
#![allow(unsafe_code, clippy::wildcard_imports)]

use core::arch::x86_64::*;

use super::super::lanes::Lanes;
use super::reg::Reg;

/// Permutes eight lanes: lane i receives the lane whose index is byte i of `order`, modulo 8.
#[inline]
#[target_feature(enable = "avx2")]
pub(super) fn permute(lanes: __m256, order: u64) -> __m256 {
    _mm256_permutevar8x32_ps(lanes, _mm256_cvtepu8_epi32(_mm_cvtsi64_si128(order as i64)))
}

/// Returns the index of the smallest value among the lanes in the mask. Replaces the last three
/// bits of each value with its lane index and takes the minimum.
#[inline]
#[target_feature(enable = "avx2")]
pub(super) fn lane_of_least(lanes: __m256, mask: __m256) -> usize {
    let numbers = _mm256_and_si256(_mm256_castps_si256(lanes), _mm256_set1_epi32(!7));
    let keys = _mm256_or_si256(numbers, _mm256_setr_epi32(0, 1, 2, 3, 4, 5, 6, 7));
    // Set all bits of the lanes outside the mask, which gives them the largest key.
    let others = _mm256_xor_si256(_mm256_castps_si256(mask), _mm256_set1_epi32(-1));
    let keys = _mm256_or_si256(keys, others);
    // Halve the number of keys: eight, four, two, one.
    let four = _mm_min_epu32(_mm256_castsi256_si128(keys), _mm256_extracti128_si256::<1>(keys));
    let two = _mm_min_epu32(four, _mm_shuffle_epi32::<0b01_00_11_10>(four));
    let one = _mm_min_epu32(two, _mm_shuffle_epi32::<0b10_11_00_01>(two));
    (_mm_cvtsi128_si32(one) & 7) as usize
}

/// Transposes four rows of four values within each 128-bit part of a register of any width.
macro_rules! columns {
    ($low:ident $high:ident, $a:expr, $b:expr, $c:expr, $d:expr) => {{
        let (a, b, c, d) = ($a, $b, $c, $d);
        let (ac, ac_hi, bd, bd_hi) = ($low(a, c), $high(a, c), $low(b, d), $high(b, d));
        let (k0, k1) = ($low(ac, bd), $high(ac, bd));
        [Reg(k0), Reg(k1), Reg($low(ac_hi, bd_hi)), Reg($high(ac_hi, bd_hi))]
    }};
}

/// Transposes four rows.
#[inline(always)]
pub(super) fn transpose([a, b, c, d]: [Reg<__m128>; 4]) -> [Reg<__m128>; 4] {
    cpu!(columns!(_mm_unpacklo_ps _mm_unpackhi_ps, a.0, b.0, c.0, d.0))
}

/// Transposes eight rows of four values. Row i is loaded next to row i + 4, so no value has to move
/// between 128-bit halves.
#[inline(always)]
pub(super) fn eight_as_columns<'a>(row: impl Fn(usize) -> &'a [f32; 4]) -> [Reg<__m256>; 4] {
    macro_rules! beside {
        ($i:literal) => {{
            let (first, last) = (Reg::<__m128>::load(row($i)), Reg::<__m128>::load(row($i + 4)));
            _mm256_insertf128_ps::<1>(_mm256_castps128_ps256(first.0), last.0)
        }};
    }
    cpu!(columns!(_mm256_unpacklo_ps _mm256_unpackhi_ps,
        beside!(0), beside!(1), beside!(2), beside!(3)))
}

/// Transposes sixteen rows of four values. Rows i, i + 4, i + 8, and i + 12 are loaded next to each
/// other.
#[inline(always)]
pub(super) fn sixteen_as_columns<'a>(row: impl Fn(usize) -> &'a [f32; 4]) -> [Reg<__m512>; 4] {
    macro_rules! beside {
        ($i:literal) => {{
            let (a, b) = (Reg::<__m128>::load(row($i)), Reg::<__m128>::load(row($i + 4)));
            let (c, d) = (Reg::<__m128>::load(row($i + 8)), Reg::<__m128>::load(row($i + 12)));
            let two = _mm512_insertf32x4::<1>(_mm512_castps128_ps512(a.0), b.0);
            _mm512_insertf32x4::<3>(_mm512_insertf32x4::<2>(two, c.0), d.0)
        }};
    }
    cpu!(columns!(_mm512_unpacklo_ps _mm512_unpackhi_ps,
        beside!(0), beside!(1), beside!(2), beside!(3)))
}

/// Transposes four rows of f64.
#[inline(always)]
pub(super) fn transpose_f64([a, b, c, d]: [Reg<__m256d>; 4]) -> [Reg<__m256d>; 4] {
    let zip = |x: __m256d, y: __m256d| cpu!((_mm256_unpacklo_pd(x, y), _mm256_unpackhi_pd(x, y)));
    let ((ab, ab_odd), (cd, cd_odd)) = (zip(a.0, b.0), zip(c.0, d.0));
    let halves = |x: __m256d, y: __m256d| {
        cpu!((_mm256_permute2f128_pd::<0x20>(x, y), _mm256_permute2f128_pd::<0x31>(x, y)))
    };
    let ((k0, k2), (k1, k3)) = (halves(ab, cd), halves(ab_odd, cd_odd));
    [Reg(k0), Reg(k1), Reg(k2), Reg(k3)]
}

/// Returns the first of four lanes followed by three copies of the last lane.
#[inline]
#[target_feature(enable = "avx2")]
pub(super) fn first_and_last(lanes: __m256d) -> __m256d {
    _mm256_permute4x64_pd::<0b11_11_11_00>(lanes)
}
