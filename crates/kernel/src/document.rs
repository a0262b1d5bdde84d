//! Document A's `InterTri` test (`docs/documents.md`) in f64 lanes, with the same operations in the
//! same order as in the document.
//!
//! ```text
//!              c3
//!              /\            h4 = c2 - c1     h2 = h1 - c1
//!          h5 /  \ h6        h5 = c3 - c1     h3 = h1 - c2
//!            /  . \          h6 = c3 - c2
//!           /  h1  \         nrm = h4 ^ h5, of unit length
//!         c1 ------ c2
//!              h4            h1 = org + dir * t, the point of the ray in the plane
//! ```
//!
//! No operation here is fused, approximated or reordered, so every lane computes the same bits as
//! the scalar listing. The resolver of `certified` uses this test.

use crate::packet::RayLanes;
use crate::simd::Lanes;
use crate::simd::Vec3;
use crate::{RayOf, Scalar, Triangle, TriangleOf};

/// Triangles as the document initializes them. The lanes contain either copies of one triangle or
/// different triangles.
#[derive(Clone, Copy)]
pub struct Tri<D> {
    c1: Vec3<D>,
    c2: Vec3<D>,
    pub(crate) nrm: Vec3<D>,
    h4: Vec3<D>,
    h5: Vec3<D>,
    h6: Vec3<D>,
}

impl<D: Lanes<Scalar = f64>> Tri<D> {
    /// Computes the edges and the normal from the corners.
    #[inline(always)]
    pub(crate) fn new([c1, c2, c3]: [Vec3<D>; 3]) -> Self {
        let (h4, h5, h6) = (c2 - c1, c3 - c1, c3 - c2);

        // A triangle with zero area keeps the zero vector as its normal, so no ray hits it.
        let normal = h4.cross(h5);
        let length = normal.dot(normal).sqrt();
        let length = D::select(length.le(D::splat(0.0)), D::splat(1.0), length);
        let nrm = Vec3 { x: normal.x / length, y: normal.y / length, z: normal.z / length };
        Self { c1, c2, nrm, h4, h5, h6 }
    }

    /// Returns the dot product of `nrm` and `dir`, and the `t` of the plane.
    #[inline(always)]
    fn plane(&self, org: Vec3<D>, dir: Vec3<D>) -> (D, D) {
        let vd = self.nrm.dot(dir);
        (vd, self.nrm.dot(self.c1 - org) / vd)
    }

    /// Returns the `t` of [`Tri::inter_tri`], without the test for a hit.
    #[inline(always)]
    pub(crate) fn t(&self, org: Vec3<D>, dir: Vec3<D>) -> D {
        self.plane(org, dir).1
    }

    /// Performs the document's test. Returns the lanes that hit the triangle, and their `t`.
    #[inline(always)]
    pub(crate) fn inter_tri(&self, org: Vec3<D>, dir: Vec3<D>, threshold: f64) -> (D::Mask, D) {
        let zero = D::splat(0.0);
        let threshold = D::splat(threshold);

        // Is the ray parallel to the plane? NaN passes this test and the next; only `t > threshold`
        // rejects it.
        let (vd, t) = self.plane(org, dir);
        let parallel = (-threshold).lt(vd) & vd.lt(threshold);

        // Is the point outside an edge? A point on the edge is inside, and a NaN is not `< 0`.
        let h1 = org + dir * t;
        let h2 = h1 - self.c1;
        let outside = self.nrm.dot(self.h4.cross(h2)).lt(zero)
            | self.nrm.dot(h2.cross(self.h5)).lt(zero)
            | self.nrm.dot(self.h6.cross(h1 - self.c2)).lt(zero);

        (!(parallel | outside) & t.gt(threshold), t)
    }

    /// Performs [`Tri::inter_tri`] within the rays' intervals: `t_min <= t < t_max`.
    #[inline(always)]
    pub(crate) fn hit(&self, rays: &RayLanes<D>, threshold: f64) -> (D::Mask, D) {
        let (hit, t) = self.inter_tri(rays.org, rays.dir, threshold);
        (hit & t.ge(rays.t_min) & t.lt(rays.t_max), t)
    }
}

impl Tri<f64> {
    /// Initializes one triangle.
    #[inline(always)]
    pub(crate) fn one<S: Scalar>(&TriangleOf(corners): &TriangleOf<S>) -> Self {
        Self::new(corners.map(|c| Vec3::splat(c.map(Into::into))))
    }
}

/// Tests one ray against one triangle, and returns t for a hit.
#[inline(always)]
pub(crate) fn hit<S: Scalar>(
    ray: &RayOf<S>,
    triangle: &TriangleOf<S>,
    threshold: f64,
) -> Option<f64> {
    let (hit, t) = Tri::one(triangle).hit(&RayLanes::of_ray(ray), threshold);
    hit.then_some(t)
}

/// Returns document A's t for a triangle that is known to be hit.
#[inline(always)]
pub(crate) fn t<S: Scalar>(ray: &RayOf<S>, triangle: &TriangleOf<S>) -> f64 {
    let rays = RayLanes::of_ray(ray);
    Tri::one(triangle).t(rays.org, rays.dir)
}

/// A triangle's plane relative to an origin.
#[derive(Clone, Copy, Debug)]
pub struct SeenPlane {
    nrm: Vec3<f64>,
    num: f64,
}

impl SeenPlane {
    #[inline(never)]
    pub(crate) fn new(triangle: &Triangle, origin: [f32; 3]) -> Self {
        let Tri { nrm, c1, .. } = Tri::one(triangle);
        Self { nrm, num: nrm.dot(c1 - Vec3::splat(origin.map(f64::from))) }
    }

    /// Returns document A's t for a ray from this origin that is known to hit the triangle.
    #[inline(always)]
    pub(crate) fn t(&self, dir: [f32; 3]) -> f64 {
        self.num / self.nrm.dot(Vec3::splat(dir.map(f64::from)))
    }
}
