//! The two-sided test by Möller and Trumbore (T. Möller and B. Trumbore, "Fast, minimum storage
//! ray/triangle intersection", Journal of Graphics Tools 2(1), 1997), which applies Cramer's rule
//! to two edges.

use intertri::simd::Vec3;

use super::intersector::{Intersector, PlainRay, splat};
use super::real::Real;

/// The test by Möller and Trumbore. A ray counts as parallel if the absolute value of the
/// determinant is at most `epsilon`.
#[derive(Clone, Copy, Debug)]
pub struct MollerTrumbore {
    /// The bound on the determinant. A bound of 0 rejects only a determinant of 0. The paper's
    /// listing uses 1e-6, which many implementations have kept.
    pub epsilon: f64,
}

/// A corner and two edges from it.
#[derive(Clone, Copy, Debug)]
pub struct Triangle<L> {
    v0: Vec3<L>,
    e1: Vec3<L>,
    e2: Vec3<L>,
}

impl Intersector for MollerTrumbore {
    type Ray<L: Real> = PlainRay<L>;
    type Triangle<L: Real> = Triangle<L>;

    #[inline(always)]
    fn ray<L: Real>(self, origin: Vec3<L>, dir: Vec3<L>) -> PlainRay<L> {
        PlainRay { origin, dir }
    }

    #[inline(always)]
    fn triangle<L: Real>(self, [v0, v1, v2]: [Vec3<L>; 3]) -> Triangle<L> {
        Triangle { v0, e1: v1 - v0, e2: v2 - v0 }
    }

    #[inline(always)]
    fn spread<L: Real>(one: &Triangle<L::Scalar>) -> Triangle<L> {
        let &Triangle { v0, e1, e2 } = one;
        Triangle { v0: splat(v0), e1: splat(e1), e2: splat(e2) }
    }

    #[inline(always)]
    fn test<L: Real>(self, triangle: &Triangle<L>, ray: &PlainRay<L>) -> (L::Mask, L) {
        let &Triangle { v0, e1, e2 } = triangle;
        let (zero, one) = (L::of(0.0), L::of(1.0));

        // origin - v0 = u e1 + v e2 - t dir, by Cramer's rule with shared products.
        let p = ray.dir.cross(e2);
        let det = e1.dot(p);
        let inverse = one / det;
        let s = ray.origin - v0;
        let u = s.dot(p) * inverse;
        let q = s.cross(e1);
        let v = ray.dir.dot(q) * inverse;
        let t = e2.dot(q) * inverse;

        let slanted = det.abs().gt(L::of(self.epsilon));
        (slanted & u.ge(zero) & v.ge(zero) & (u + v).le(one) & t.gt(zero), t)
    }
}
