//! The precheck for packets: finds the rays, from arbitrary origins, that certainly miss a
//! triangle.
//!
//! ```text
//!   V/h = v·d + h5/h·m     with the moments   v = h5 × c1 / h         of an edge
//!   W/h = w·d - h4/h·m                        w = c1 × h4 / h
//!   D/h = n·d / h                             m = d × o               of a ray
//!   U = D - V - W          a miss if two of the three have different signs
//! ```
//!
//! The precheck needs no translation and only sixteen values per triangle. The price is an error
//! that grows with the distance from the world's origin. This is acceptable because the filter
//! tests every pair that passes the precheck. `docs/numerics/certified.md`, section 8, has the
//! bound and the proof.

use crate::Triangle;
use crate::packet::TriangleBlock;
use crate::simd::Lanes;
use crate::simd::Vec3;

use super::bound;
use super::edges::{Rays, Triangles};
use super::room::Room;

/// The constants of a triangle, computed once.
//
// All values that a precheck reads fit in one cache line.
#[derive(Clone, Copy, Debug)]
#[repr(C, align(64))]
pub(crate) struct Constants {
    v: Vec3<f32>,
    w: Vec3<f32>,
    /// The edges and the normal, divided by h.
    h5: Vec3<f32>,
    minus_h4: Vec3<f32>,
    n: Vec3<f32>,
    /// `PRECHECK (|c1|₁ + h)`
    reach: f32,
    /// The longest edge, rounded up; NaN if f32 must not decide.
    pub(super) h: f32,
}

impl Constants {
    /// Computes the constants of a triangle.
    pub(super) fn new(triangle: &Triangle) -> Self {
        let one = TriangleBlock::<1>::new(core::slice::from_ref(triangle));
        let Triangles { c1, minus_h4, h5, n, h, .. } =
            Triangles::<f32>::of_block(&one, &Room::NONE);
        let scale = 1.0 / h;
        Self {
            v: h5.cross_fused(c1) * scale,
            w: minus_h4.cross_fused(c1) * scale,
            h5: h5 * scale,
            minus_h4: minus_h4 * scale,
            n: n * scale,
            reach: bound::PRECHECK * (c1.norm1() + h),
            h,
        }
    }
}

/// The values of rays that the precheck needs.
#[derive(Clone, Copy)]
pub(crate) struct Precheck<F> {
    dir: Vec3<F>,
    moment: Vec3<F>,
    len: F,
    /// The part of the bound that depends on the origin.
    away: F,
}

impl<F: Lanes<Scalar = f32>> Precheck<F> {
    /// Computes the moments of the rays.
    #[inline(always)]
    pub(super) fn new(rays: &Rays<F>) -> Self {
        let (org, dir, len) = (rays.org(), rays.dir(), rays.len());
        // `PRECHECK |d|₂ |o|₁ + off`. The triangle's part of the bound, `reach`, is added for each
        // triangle.
        let away = (len * F::splat(bound::PRECHECK)).mul_add(org.norm1(), rays.off());
        Self { dir, moment: dir.cross_fused(org), len, away }
    }

    /// Returns V, W, U, and the denominator, each divided by h, and their common error bound.
    #[inline(always)]
    pub(super) fn values(&self, at: &Constants) -> ([F; 4], F) {
        let splat = |x: Vec3<f32>| Vec3::<F>::splat([x.x, x.y, x.z]);

        // Two short sums take less time than one long sum.
        let v = self.moment.dot_fused(splat(at.h5)) + self.dir.dot_fused(splat(at.v));
        let w = self.moment.dot_fused(splat(at.minus_h4)) + self.dir.dot_fused(splat(at.w));
        let den = self.dir.dot_fused(splat(at.n));
        ([v, w, (den - v) - w, den], self.len.mul_add(F::splat(at.reach), self.away))
    }

    /// Returns the lanes that certainly miss: two edge functions certainly have different signs,
    /// and the ray does not graze the plane.
    #[inline(always)]
    pub(super) fn sure_miss(&self, at: &Constants) -> F::Mask {
        let ([v, w, u, den], bound) = self.values(at);
        let (least, most) = (v.min(w).min(u), v.max(w).max(u));
        // If f32 must not decide, the bound is NaN, so the comparison is false.
        den.abs().min(most).min(-least).gt(bound)
    }
}
