//! Cramer's rule with coefficient vectors (document D).
//!
//! The equation is `u AB + v AC - t PN = AP`. `T = AB × AC` and `D = -T` depend only on the
//! triangle; `U` and `V` also depend on the ray's origin. The document's test is one-sided and
//! leaves the edge `u + v = 1` open; here it is two-sided and closed, like all other methods. The
//! document's sign for `t` is corrected: the numerator must have the same sign as the determinant.

use intertri::simd::Vec3;

use super::intersector::{Intersector, PlainRay, splat};
use super::real::Real;

/// The test by Cramer's rule.
#[derive(Clone, Copy, Debug)]
pub struct Cramer;

/// A corner, the two sides from it, and their cross product.
#[derive(Clone, Copy, Debug)]
pub struct Triangle<L> {
    a: Vec3<L>,
    ab: Vec3<L>,
    ac: Vec3<L>,
    t: Vec3<L>,
}

impl Intersector for Cramer {
    type Ray<L: Real> = PlainRay<L>;
    type Triangle<L: Real> = Triangle<L>;

    #[inline(always)]
    fn ray<L: Real>(self, origin: Vec3<L>, dir: Vec3<L>) -> PlainRay<L> {
        PlainRay { origin, dir }
    }

    #[inline(always)]
    fn triangle<L: Real>(self, [a, b, c]: [Vec3<L>; 3]) -> Triangle<L> {
        let (ab, ac) = (b - a, c - a);
        Triangle { a, ab, ac, t: ab.cross(ac) }
    }

    #[inline(always)]
    fn spread<L: Real>(one: &Triangle<L::Scalar>) -> Triangle<L> {
        let &Triangle { a, ab, ac, t } = one;
        Triangle { a: splat(a), ab: splat(ab), ac: splat(ac), t: splat(t) }
    }

    #[inline(always)]
    fn test<L: Real>(self, triangle: &Triangle<L>, ray: &PlainRay<L>) -> (L::Mask, L) {
        let &Triangle { a, ab, ac, t } = triangle;
        let zero = L::of(0.0);

        // Compute the part that depends on the ray's origin.
        let ap = ray.origin - a;
        let (u, v, t_ap) = (ac.cross(ap), ap.cross(ab), t.dot(ap));

        // The three products are negated where necessary so that the determinant is positive. The
        // hit test then does not need a division.
        let det = -t.dot(ray.dir);
        let (d, u, v) = (det.abs(), u.dot(ray.dir).flip(det), v.dot(ray.dir).flip(det));
        let hit = u.ge(zero) & v.ge(zero) & (u + v).le(d) & t_ap.flip(det).gt(zero) & d.gt(zero);
        (hit, t_ap / det)
    }
}
