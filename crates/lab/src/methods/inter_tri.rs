//! The `InterTri` test (document A) in any precision. In f64, it matches the reference
//! implementation bit for bit.

use intertri::simd::Vec3;

use super::intersector::{Intersector, PlainRay, splat};
use super::real::Real;

/// The `InterTri` test, with document A's threshold for the parallel test and for `t`.
#[derive(Clone, Copy, Debug)]
pub struct InterTri {
    /// The document's `Threshold`.
    pub threshold: f64,
}

/// A triangle with the values that document A precomputes.
#[derive(Clone, Copy, Debug)]
pub struct Triangle<L> {
    c1: Vec3<L>,
    c2: Vec3<L>,
    h4: Vec3<L>,
    h5: Vec3<L>,
    h6: Vec3<L>,
    nrm: Vec3<L>,
}

impl Intersector for InterTri {
    type Ray<L: Real> = PlainRay<L>;
    type Triangle<L: Real> = Triangle<L>;

    #[inline(always)]
    fn ray<L: Real>(self, origin: Vec3<L>, dir: Vec3<L>) -> PlainRay<L> {
        PlainRay { origin, dir }
    }

    #[inline(always)]
    fn triangle<L: Real>(self, [c1, c2, c3]: [Vec3<L>; 3]) -> Triangle<L> {
        let (h4, h5, h6) = (c2 - c1, c3 - c1, c3 - c2);
        let c = h4.cross(h5);
        let length = c.dot(c).sqrt();
        let length = L::select(length.le(L::of(0.0)), L::of(1.0), length);
        let nrm = Vec3 { x: c.x / length, y: c.y / length, z: c.z / length };
        Triangle { c1, c2, h4, h5, h6, nrm }
    }

    #[inline(always)]
    fn spread<L: Real>(one: &Triangle<L::Scalar>) -> Triangle<L> {
        let &Triangle { c1, c2, h4, h5, h6, nrm } = one;
        let (h4, h5, h6) = (splat(h4), splat(h5), splat(h6));
        Triangle { c1: splat(c1), c2: splat(c2), h4, h5, h6, nrm: splat(nrm) }
    }

    #[inline(always)]
    fn test<L: Real>(self, triangle: &Triangle<L>, ray: &PlainRay<L>) -> (L::Mask, L) {
        let &Triangle { c1, c2, h4, h5, h6, nrm } = triangle;
        let threshold = L::of(self.threshold);

        // Intersect the ray with the triangle's plane.
        let vd = nrm.dot(ray.dir);
        let parallel = vd.gt(-threshold) & vd.lt(threshold);
        let t = nrm.dot(c1 - ray.origin) / vd;

        // Determine on which side of each edge the ray meets the plane.
        let h1 = ray.origin + ray.dir * t;
        let (h2, h3) = (h1 - c1, h1 - c2);
        let zero = L::of(0.0);
        let inside = nrm.dot(h4.cross(h2)).ge(zero)
            & nrm.dot(h2.cross(h5)).ge(zero)
            & nrm.dot(h6.cross(h3)).ge(zero);
        (!parallel & inside & t.gt(threshold), t)
    }
}
