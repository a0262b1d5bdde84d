//! What is given, by its bits: no setting of the CPU changes what that says.

use super::numbers::Pair;
use crate::{Ray, Triangle};

const INFINITY: u32 = f32::INFINITY.to_bits();
const SMALLEST_NORMAL: u32 = f32::MIN_POSITIVE.to_bits();

/// A number without its sign.
#[inline(always)]
fn size(x: f32) -> u32 {
    x.to_bits() & u32::MAX >> 1
}

/// Whether no number is subnormal, the ends of the interval among them: a CPU may be set to read those as 0.
#[inline(always)]
pub fn is_plain(ray: &Ray, triangle: &Triangle) -> bool {
    let numbers = triangle.0.as_flattened().iter().chain(&ray.origin).chain(&ray.dir);
    let numbers = numbers.chain([&ray.t_min, &ray.t_max]);
    numbers.fold(true, |plain, &x| plain & (size(x).wrapping_sub(1) >= SMALLEST_NORMAL - 1))
}

/// Whether the CPU reads subnormal numbers as they are, not as 0: so where nothing else is asked of them.
#[inline]
pub fn subnormals_are_read() -> bool {
    f64::from(core::hint::black_box(f32::from_bits(1))) != 0.0
}

/// Whether no coordinate is NaN or infinite.
#[inline(always)]
pub(super) fn is_finite(ray: &Ray, triangle: &Triangle) -> bool {
    let numbers = triangle.0.as_flattened().iter().chain(&ray.origin).chain(&ray.dir);
    numbers.fold(true, |finite, &x| finite & (size(x) < INFINITY))
}

/// The numbers of a ray and a triangle.
#[inline(always)]
pub(super) fn pair(ray: &Ray, triangle: &Triangle) -> Pair<f32> {
    Pair { origin: ray.origin, dir: ray.dir, corners: triangle.0 }
}
