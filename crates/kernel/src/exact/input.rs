//! What is given, by its bits: no setting of the CPU changes what that says.

use super::numbers::Pair;
use crate::{Ray, Triangle};

const EXPONENT: u32 = f32::INFINITY.to_bits();
const FRACTION: u32 = f32::MIN_POSITIVE.to_bits() - 1;

/// Whether a number is subnormal: as a mask, which the compiler can ask of several at once.
#[inline(always)]
fn is_subnormal(x: u32) -> u32 {
    u32::from(x & EXPONENT == 0) & u32::from(x & FRACTION != 0)
}

/// Whether no number is subnormal, the ends of the interval among them: a CPU may be set to read those as 0.
#[inline(always)]
pub fn is_plain(ray: &Ray, triangle: &Triangle) -> bool {
    let (ray, triangle) = bits(ray, triangle);
    let mut subnormal = is_subnormal(triangle[8]);
    for i in 0..8 {
        subnormal |= is_subnormal(ray[i]) | is_subnormal(triangle[i]);
    }
    subnormal == 0
}

/// Whether the CPU reads subnormal numbers as they are, not as 0: so where nothing else is asked of them.
#[inline]
pub fn subnormals_are_read() -> bool {
    f64::from(core::hint::black_box(f32::from_bits(1))) != 0.0
}

/// Whether no coordinate is NaN or infinite.
#[inline(always)]
pub(super) fn is_finite(ray: &Ray, triangle: &Triangle) -> bool {
    let (ray, triangle) = bits(ray, triangle);
    let finite = |x: &u32| x & EXPONENT != EXPONENT;
    triangle.iter().all(finite) && ray[..3].iter().all(finite) && ray[4..7].iter().all(finite)
}

/// The numbers of a ray, its interval's ends the fourth and the last, and of a triangle.
#[inline(always)]
fn bits<'a>(ray: &'a Ray, triangle: &'a Triangle) -> (&'a [u32; 8], &'a [u32; 9]) {
    (bytemuck::cast_ref(ray), bytemuck::cast_ref(triangle))
}

/// The numbers of a ray and a triangle.
#[inline(always)]
pub(super) fn pair(ray: &Ray, triangle: &Triangle) -> Pair<f32> {
    Pair { origin: ray.origin, dir: ray.dir, corners: triangle.0 }
}
