//! The test by signed volumes (R. J. Segura and F. R. Feito, "Algorithms to test ray-triangle
//! intersection. Comparative study", WSCG 2001). With corners relative to the ray's origin,
//! `d · (B × C)` is a signed volume, whose sign shows on which side of the edge BC the ray passes.
//! The other two edges are tested in the same way.

use intertri::simd::Vec3;

use super::intersector::{Intersector, PlainRay, splat3};
use super::real::Real;

/// The test by signed volumes.
#[derive(Clone, Copy, Debug)]
pub struct SignedVolume;

impl Intersector for SignedVolume {
    type Ray<L: Real> = PlainRay<L>;
    type Triangle<L: Real> = [Vec3<L>; 3];

    #[inline(always)]
    fn ray<L: Real>(self, origin: Vec3<L>, dir: Vec3<L>) -> PlainRay<L> {
        PlainRay { origin, dir }
    }

    #[inline(always)]
    fn triangle<L: Real>(self, corners: [Vec3<L>; 3]) -> [Vec3<L>; 3] {
        corners
    }

    #[inline(always)]
    fn spread<L: Real>(one: &[Vec3<L::Scalar>; 3]) -> [Vec3<L>; 3] {
        splat3(*one)
    }

    #[inline(always)]
    fn test<L: Real>(self, corners: &[Vec3<L>; 3], ray: &PlainRay<L>) -> (L::Mask, L) {
        let seen = |k: usize| corners[k] - ray.origin;
        let (a, b, c) = (seen(0), seen(1), seen(2));
        let zero = L::of(0.0);
        let bc = b.cross(c);
        let u = ray.dir.dot(bc);
        let v = ray.dir.dot(c.cross(a));
        let w = ray.dir.dot(a.cross(b));
        let same = (u.ge(zero) & v.ge(zero) & w.ge(zero)) | (u.le(zero) & v.le(zero) & w.le(zero));
        // A determinant of 0 makes t NaN or infinite.
        let t = a.dot(bc) / (u + v + w);
        (same & t.gt(zero) & t.lt(L::of(f64::INFINITY)), t)
    }
}
