//! Embree's two tests (I. Wald, S. Woop, C. Benthin, G. S. Johnson, M. Ernst, "Embree: a kernel
//! framework for efficient CPU ray tracing", ACM Transactions on Graphics 33(4), 2014), as in
//! version 4.

use intertri::simd::Lanes;
use intertri::simd::Vec3;

use super::intersector::{Intersector, PlainRay, splat, splat3};
use super::real::{Number, Real};

/// The fast form. It multiplies the ray's moment about the first corner by two edges to get two
/// edge values, and subtracts these from the determinant to get the third.
#[derive(Clone, Copy, Debug)]
pub struct EdgeForm;

/// The first corner, two edges, and their cross product.
#[derive(Clone, Copy, Debug)]
pub struct Edges<L> {
    v0: Vec3<L>,
    e1: Vec3<L>,
    e2: Vec3<L>,
    n: Vec3<L>,
}

impl Intersector for EdgeForm {
    type Ray<L: Real> = PlainRay<L>;
    type Triangle<L: Real> = Edges<L>;

    #[inline(always)]
    fn ray<L: Real>(self, origin: Vec3<L>, dir: Vec3<L>) -> PlainRay<L> {
        PlainRay { origin, dir }
    }

    #[inline(always)]
    fn triangle<L: Real>(self, [v0, v1, v2]: [Vec3<L>; 3]) -> Edges<L> {
        let (e1, e2) = (v0 - v1, v2 - v0);
        Edges { v0, e1, e2, n: e2.cross(e1) }
    }

    #[inline(always)]
    fn spread<L: Real>(one: &Edges<L::Scalar>) -> Edges<L> {
        let &Edges { v0, e1, e2, n } = one;
        Edges { v0: splat(v0), e1: splat(e1), e2: splat(e2), n: splat(n) }
    }

    #[inline(always)]
    fn test<L: Real>(self, triangle: &Edges<L>, ray: &PlainRay<L>) -> (L::Mask, L) {
        let &Edges { v0, e1, e2, n } = triangle;
        let zero = L::of(0.0);
        let c = v0 - ray.origin;
        let r = c.cross(ray.dir);
        let den = n.dot(ray.dir);
        let (size, u, v) = (den.abs(), r.dot(e2).flip(den), r.dot(e1).flip(den));
        let t = n.dot(c).flip(den);
        let hit = size.gt(zero) & u.ge(zero) & v.ge(zero) & (u + v).le(size) & t.gt(zero);
        (hit, t / size)
    }
}

/// The robust form. Each side's value is computed from its edge and the sum of its ends, so two
/// adjacent triangles get the same value with opposite signs. The test allows a slack of one
/// rounding unit, relative to the sum of the three values. It loses no hits at an edge, but counts
/// many of them twice.
#[derive(Clone, Copy, Debug)]
pub struct Robust;

impl Intersector for Robust {
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
        let (v0, v1, v2) = (seen(0), seen(1), seen(2));
        let (e0, e1, e2) = (v2 - v0, v0 - v1, v1 - v2);
        let u = e0.cross(v2 + v0).dot(ray.dir);
        let v = e1.cross(v0 + v1).dot(ray.dir);
        let w = e2.cross(v1 + v2).dot(ray.dir);

        let slack = L::of(L::Scalar::UNIT) * (u + v + w).abs();
        let same = (u.ge(-slack) & v.ge(-slack) & w.ge(-slack))
            | (u.le(slack) & v.le(slack) & w.le(slack));

        let n = stable_normal(e0, e1, e2);
        let den = n.dot(ray.dir);
        let t = n.dot(v0) / den;
        (same & den.abs().gt(L::of(0.0)) & t.gt(L::of(0.0)) & t.lt(L::of(f64::INFINITY)), t)
    }
}

/// Computes the normal from two cross products of edges. For each component, it chooses the cross
/// product whose terms are smaller.
#[inline(always)]
fn stable_normal<L: Lanes>(a: Vec3<L>, b: Vec3<L>, c: Vec3<L>) -> Vec3<L> {
    let (ab, bc) = (a.cross(b), b.cross(c));
    let smaller =
        |ab_term: L, bc_term: L, ab: L, bc: L| L::select(ab_term.abs().lt(bc_term.abs()), ab, bc);
    Vec3 {
        x: smaller(a.z * b.y, b.z * c.y, ab.x, bc.x),
        y: smaller(a.x * b.z, b.x * c.z, ab.y, bc.y),
        z: smaller(a.y * b.x, b.y * c.x, ab.z, bc.z),
    }
}
