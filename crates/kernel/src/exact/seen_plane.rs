//! A triangle's plane relative to an origin. Comparing the planes of two triangles shows which
//! triangle a ray meets first. f64 is nearly always precise enough.
//!
//! Let n be a triangle's normal, A one of its corners relative to the ray's origin, and d the ray's
//! direction. Then T is `A·n` and D is `d·n`. Both have error bounds.
//!
//! ```text
//!   t = |T| / |D|, so t₁ < t₂ if and only if |T₁ D₂| < |T₂ D₁|.
//! ```
//!
//! `docs/numerics/exact.md`, section 9, has the bounds and the proof.

use core::cmp::Ordering;

use super::input::{is_plain, is_tame_dir, subnormals_are_read};
use super::tier::is_f64;
use crate::simd::Vec3;
use crate::{RayOf, Scalar, TriangleOf};

/// `2^-49`, which is `16w`, where w is half an ulp of 1. Apart from second-order terms, the errors
/// of T and D are at most `8w` and `7w` times their permanents.
const BOUND: f64 = 16.0 * (f64::EPSILON / 2.0);

/// A triangle's plane relative to the origin of rays that are known to hit the triangle.
#[derive(Clone, Copy, Debug)]
pub struct SeenPlane<S = f32> {
    origin: [S; 3],
    /// The normal of the plane.
    n: Vec3<f64>,
    /// The permanents of the normal, times `BOUND`.
    n_err: Vec3<f64>,
    /// |T|, and the permanent of T times `BOUND`, or NaN if nothing is certain.
    num: f64,
    num_err: f64,
}

impl<S: Scalar> SeenPlane<S> {
    /// Computes a triangle's plane relative to an origin.
    #[inline(never)]
    pub fn new(triangle: &TriangleOf<S>, origin: [S; 3]) -> Self {
        let [c1, c2, c3] = triangle.0.map(vec3);
        let (a, h4, h5) = (c1 - vec3(origin), c2 - c1, c3 - c1);
        let (n, brackets) = (h4.cross(h5), h4.abs().permanents(h5.abs()));
        let (num, num_err) = (n.dot(a), brackets.dot(a.abs()) * BOUND);
        // Nothing is certain if a subnormal number may have been read as 0 or if the bound does not
        // cover the coordinates.
        let sound = !is_f64::<S>() || is_plain(&RayOf::new(origin, [S::ONE; 3]), triangle);
        let num_err = if sound && subnormals_are_read() { num_err } else { f64::NAN };
        Self { origin, n, n_err: brackets * BOUND, num: num.abs(), num_err }
    }

    /// Returns which of two planes a ray meets first, or `None` if that is uncertain. The ray must
    /// meet both. An f32 ray must start at the origin of both planes; for an f64 ray, this function
    /// checks that the ray starts at the origin of `self`.
    #[inline(always)]
    pub fn order(&self, other: &Self, ray: &RayOf<S>) -> Option<Ordering> {
        if const { is_f64::<S>() } {
            let same = |a: S, b: S| a.rank() == b.rank() && a.is_negative() == b.is_negative();
            let starts_there = (0..3).all(|k| same(self.origin[k], ray.origin[k]));
            if !(starts_there && is_tame_dir(ray.dir)) {
                return None;
            }
        }
        let dir = vec3(ray.dir);
        let ((den, den_err), (other_den, other_err)) = (self.den(dir), other.den(dir));
        // Compare magnitudes, not signed values: two planes can be ordered even if one is so near
        // the origin that the sign of its T is unknown.
        let gap = self.num * other_den - other.num * den;
        // The sum of the error bounds on the two products, whose factors are all inexact (exact.md,
        // section 9).
        let err = (self.num + self.num_err) * other_err
            + self.num_err * other_den
            + (other.num + other.num_err) * den_err
            + other.num_err * den;
        // The effect of underflow in f64 is smaller than `MIN_POSITIVE`. The comparison is false
        // for NaN.
        let is_sure = gap.abs() > err + f64::MIN_POSITIVE;
        is_sure.then_some(if gap < 0.0 { Ordering::Less } else { Ordering::Greater })
    }

    /// Returns |D| and the permanent of D times `BOUND`.
    #[inline(always)]
    fn den(&self, dir: Vec3<f64>) -> (f64, f64) {
        (self.n.dot(dir).abs(), self.n_err.dot(dir.abs()))
    }
}

#[inline(always)]
fn vec3<S: Scalar>(v: [S; 3]) -> Vec3<f64> {
    Vec3::splat(v.map(Into::into))
}

#[cfg(test)]
mod tests {
    use super::SeenPlane;
    use crate::exact::test_numbers::random;
    use crate::exact::{Tier, order_from};
    use crate::{Ray64, TriangleOf};

    /// Tests triangles that a ray meets at almost the same t, including triangles so small or so
    /// large that products of six coordinates underflow or overflow.
    #[test]
    fn what_is_sure_of_f64_is_what_integers_say() {
        let mut random = random();
        let mut sure = [0; 4];
        for i in 0..40_000 {
            let size = 2.0_f64.powi([0, -170, 200, -100][i % 4]);
            let mut point = || [0; 3].map(|_| size * random());
            let (origin, dir) = (point(), point());
            let ray = Ray64::new(origin, dir);
            let [one, other] = [1.0, 1.0 + 2.0_f64.powi(-30 - (i as i32 / 4) % 30)].map(|t| {
                let ([a, b], at) = ([point(), point()], |k: usize| origin[k] + t * dir[k]);
                let axes = [0, 1, 2];
                let c = axes.map(|k| at(k) - a[k] - b[k]);
                TriangleOf([axes.map(|k| at(k) + a[k]), axes.map(|k| at(k) + b[k]), c])
            });
            let seen = |triangle| SeenPlane::new(triangle, origin);
            let elsewhere = Ray64::new(dir, dir);
            assert_eq!(seen(&one).order(&seen(&other), &elsewhere), None);
            let Some(order) = seen(&one).order(&seen(&other), &ray) else { continue };
            assert_eq!(order, order_from(Tier::Narrow, &ray, &one, &other), "{ray:?}");
            sure[i % 4] += 1;
        }
        let [plain, small, large, _] = sure;
        assert!(plain > 4000 && plain < 9900 && small == 0 && large == 0, "{sure:?}");
    }
}
