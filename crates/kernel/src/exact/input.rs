//! Tests the bits of the input, so that no CPU setting can affect the results.

use super::tier::is_f64;
use crate::{RayOf, Scalar, TriangleOf};

/// The number of subnormal magnitudes.
const FRACTION: u32 = f32::MIN_POSITIVE.to_bits() - 1;

/// Returns 1 if a number is subnormal, otherwise 0. An integer lets the compiler test several
/// numbers at once.
#[inline(always)]
fn is_subnormal(x: u32) -> u32 {
    u32::from(below_size(x) < FRACTION)
}

/// Returns the bits of the magnitude, minus 1. Of 0, they wrap.
#[inline(always)]
fn below_size(x: u32) -> u32 {
    (x & (u32::MAX >> 1)).wrapping_sub(1)
}

/// Returns whether the first tier may decide, because rounding is the only error of f64 arithmetic
/// on this ray and this triangle. If an f32 is subnormal, including the ends of the interval, the CPU
/// must not be set to read subnormals as 0. No f64 may be so large that a product overflows, or so
/// small that one underflows.
#[inline(always)]
pub fn is_plain<S: Scalar>(ray: &RayOf<S>, triangle: &TriangleOf<S>) -> bool {
    if const { is_f64::<S>() } {
        is_tame(bytemuck::cast_ref(ray), bytemuck::cast_ref(triangle))
    } else {
        has_no_subnormal(bytemuck::cast_ref(ray), bytemuck::cast_ref(triangle))
            || subnormals_are_read()
    }
}

#[inline(always)]
fn has_no_subnormal(ray: &[u32; 8], triangle: &[u32; 9]) -> bool {
    // Run all seventeen tests without a branch, because the numbers are nearly always plain.
    let mut subnormal = is_subnormal(triangle[8]);
    for i in 0..8 {
        subnormal |= is_subnormal(ray[i]) | is_subnormal(triangle[i]);
    }
    subnormal == 0
}

/// Returns the lanes that satisfy the condition of [`is_plain`]. The last two rows hold the ends of
/// the intervals.
#[inline(always)]
pub(super) fn plain_lanes<S: Scalar>(rows: &[[S; 8]; 17]) -> u32 {
    let mut odd = [0_u32; 8];
    if const { is_f64::<S>() } {
        let rows: &[[u64; 8]; 17] = bytemuck::cast_ref(rows);
        for row in &rows[..15] {
            for (odd, x) in odd.iter_mut().zip(row) {
                *odd |= is_wild(*x);
            }
        }
        for row in &rows[15..] {
            for (odd, x) in odd.iter_mut().zip(row) {
                *odd |= is_subnormal64(*x);
            }
        }
    } else {
        let rows: &[[u32; 8]; 17] = bytemuck::cast_ref(rows);
        // Keep the least number of each lane, and compare once.
        let mut least = [u32::MAX; 8];
        for row in rows {
            for (least, x) in least.iter_mut().zip(row) {
                *least = below_size(*x).min(*least);
            }
        }
        odd = least.map(|least| u32::from(least < FRACTION));
        if odd != [0; 8] && subnormals_are_read() {
            return u32::MAX;
        }
    }
    if odd == [0; 8] {
        return 0xff;
    }
    (0..8).map(|lane| u32::from(odd[lane] == 0) << lane).sum()
}

/// `2^-200` and `2^300`: nonzero magnitudes must be between these limits.
const TAME: [u64; 2] = [(1023 - 200) << 52, (1023 + 300) << 52];

/// Returns whether a direction satisfies the condition of [`is_plain`] for f64.
#[inline(always)]
pub(super) fn is_tame_dir<S: Scalar>(dir: [S; 3]) -> bool {
    let [low, high] = TAME.map(f64::from_bits);
    let tame = |x: S| {
        let size = Into::<f64>::into(x).abs();
        u32::from(size >= low) & u32::from(size <= high) | u32::from(size == 0.0)
    };
    dir.map(tame) == [1; 3]
}

/// Tests the condition of [`is_plain`] for f64. `docs/numerics/f64.md`, section 3, derives it.
#[inline(always)]
fn is_tame(ray: &[u64; 8], triangle: &[u64; 9]) -> bool {
    let mut any = is_wild(triangle[8]) | is_subnormal64(ray[3]) | is_subnormal64(ray[7]);
    for i in 0..3 {
        any |= is_wild(ray[i]) | is_wild(ray[4 + i]);
    }
    for x in &triangle[..8] {
        any |= is_wild(*x);
    }
    any == 0
}

/// Returns 1 if the magnitude of a number is not 0 and not within [`TAME`], otherwise 0.
#[inline(always)]
fn is_wild(x: u64) -> u32 {
    let size = x & (u64::MAX >> 1);
    // One comparison covers both limits, because a number below the first wraps around to a large
    // one.
    let beyond = size.wrapping_sub(TAME[0]) > TAME[1] - TAME[0];
    u32::from(beyond) & u32::from(size != 0)
}

/// Returns 1 if a number is subnormal, otherwise 0.
#[inline(always)]
fn is_subnormal64(x: u64) -> u32 {
    let size = x & (u64::MAX >> 1);
    u32::from(size.wrapping_sub(1) < f64::MIN_POSITIVE.to_bits() - 1)
}

/// Returns whether the CPU reads subnormal numbers unchanged, which is the default, instead of
/// reading them as 0.
#[inline]
pub fn subnormals_are_read() -> bool {
    f64::from(core::hint::black_box(f32::from_bits(1))) != 0.0
}

/// Returns whether all coordinates are finite.
#[inline(always)]
pub(super) fn is_finite<S: Scalar>(ray: &RayOf<S>, triangle: &TriangleOf<S>) -> bool {
    let finite = |x: &S| x.is_finite();
    triangle.0.as_flattened().iter().all(finite)
        && ray.origin.iter().all(finite)
        && ray.dir.iter().all(finite)
}
