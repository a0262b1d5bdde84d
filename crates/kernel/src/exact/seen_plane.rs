//! A triangle's plane as it is seen from one origin: which of two a ray meets first, nearly always in f64.
//!
//! ```text
//!   t₁ < t₂   where   |T₁ D₂| < |T₂ D₁|        each of the four within a bound
//! ```
//!
//! Bounds and proof: `docs/numerics/exact.md`, section 9.

use core::cmp::Ordering;

use super::input::subnormals_are_read;
use crate::simd::Vec3;
use crate::{Ray, Triangle};

/// `2^-49`, which is `16w`: T and D are within half of this times their permanents.
const BOUND: f64 = 16.0 * (f64::EPSILON / 2.0);

/// A triangle, and its plane as it is seen from the origin of rays that are known to hit it.
#[derive(Clone, Copy, Debug)]
pub struct SeenPlane {
    triangle: Triangle,
    /// The normal.
    n: Vec3<f64>,
    /// `BOUND` times its permanents, component by component.
    n_err: Vec3<f64>,
    /// |T|, and twice what it may be off by.
    num: f64,
    num_err: f64,
}

impl SeenPlane {
    /// From an origin.
    #[inline(never)]
    pub fn new(triangle: &Triangle, origin: [f32; 3]) -> Self {
        let [c1, c2, c3] = triangle.0.map(vec3);
        let (a, h4, h5) = (c1 - vec3(origin), c2 - c1, c3 - c1);
        let (n, brackets) = (h4.cross(h5), h4.abs().permanents(h5.abs()));
        let (num, num_err) = (n.dot(a), brackets.dot(a.abs()) * BOUND);
        // Where a subnormal number may have been read as 0, nothing is sure.
        let num_err = if subnormals_are_read() { num_err } else { f64::NAN };
        Self { triangle: *triangle, n, n_err: brackets * BOUND, num: num.abs(), num_err }
    }

    /// Which of two planes a ray from there meets first, both of which it is known to meet.
    #[inline(always)]
    pub fn order(&self, other: &Self, ray: &Ray) -> Ordering {
        let dir = vec3(ray.dir);
        let ((den, den_err), (other_den, other_err)) = (self.den(dir), other.den(dir));
        let gap = self.num * other_den - other.num * den;
        let err = (self.num + self.num_err) * other_err
            + self.num_err * other_den
            + (other.num + other.num_err) * den_err
            + other.num_err * den;
        // False with a NaN, too.
        if gap.abs() > err {
            return if gap < 0.0 { Ordering::Less } else { Ordering::Greater };
        }
        super::order(ray, &self.triangle, &other.triangle)
    }

    /// |D|, and twice what it may be off by.
    #[inline(always)]
    fn den(&self, dir: Vec3<f64>) -> (f64, f64) {
        (self.n.dot(dir).abs(), self.n_err.dot(dir.abs()))
    }
}

#[inline(always)]
fn vec3(v: [f32; 3]) -> Vec3<f64> {
    Vec3::splat(v.map(f64::from))
}
