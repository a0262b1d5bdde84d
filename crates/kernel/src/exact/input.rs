//! Tests the bits of the input, so that no CPU setting can affect the results.

use super::numbers::Pair;
use super::tier::is_f64;
use crate::{RayOf, Scalar, TriangleOf};

const EXPONENT: u32 = f32::INFINITY.to_bits();
const FRACTION: u32 = f32::MIN_POSITIVE.to_bits() - 1;

/// Returns 1 if a number is subnormal, otherwise 0. An integer lets the compiler test several
/// numbers at once.
#[inline(always)]
fn is_subnormal(x: u32) -> u32 {
    u32::from(x & EXPONENT == 0) & u32::from(x & FRACTION != 0)
}

/// Returns whether the first tier may decide, because rounding is the only error of f64 arithmetic
/// on this ray and this triangle. No f32 may be subnormal, including the ends of the interval,
/// because a CPU may be set to read subnormals as 0. No f64 may be so large that a product
/// overflows, or so small that one underflows.
#[inline(always)]
pub fn is_plain<S: Scalar>(ray: &RayOf<S>, triangle: &TriangleOf<S>) -> bool {
    if const { is_f64::<S>() } {
        is_tame(bytemuck::cast_ref(ray), bytemuck::cast_ref(triangle))
    } else {
        has_no_subnormal(bytemuck::cast_ref(ray), bytemuck::cast_ref(triangle))
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
    let size = |x: u64| x & (u64::MAX >> 1);
    let wild = |x: u64| {
        // One comparison covers both limits, because a number below the first wraps around to a
        // large one.
        let beyond = size(x).wrapping_sub(TAME[0]) > TAME[1] - TAME[0];
        u32::from(beyond) & u32::from(size(x) != 0)
    };
    let subnormal = |x: u64| u32::from(size(x).wrapping_sub(1) < f64::MIN_POSITIVE.to_bits() - 1);
    let mut any = wild(triangle[8]) | subnormal(ray[3]) | subnormal(ray[7]);
    for i in 0..3 {
        any |= wild(ray[i]) | wild(ray[4 + i]);
    }
    for x in &triangle[..8] {
        any |= wild(*x);
    }
    any == 0
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

/// Collects the coordinates of a ray and a triangle.
#[inline(always)]
pub(super) fn pair<S: Scalar>(ray: &RayOf<S>, triangle: &TriangleOf<S>) -> Pair<S> {
    Pair { origin: ray.origin, dir: ray.dir, corners: triangle.0 }
}
