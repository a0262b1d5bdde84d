//! The interface of a ray/triangle test, generic over lanes.

use intertri::simd::Vec3;

use super::real::Real;

/// A way to test a ray against a triangle.
pub trait Intersector: Copy {
    /// A ray with what is computed from it once.
    type Ray<L: Real>: Copy;
    /// A triangle with what is computed from it once.
    type Triangle<L: Real>: Copy;

    /// Rays from their origins and directions.
    fn ray<L: Real>(self, origin: Vec3<L>, dir: Vec3<L>) -> Self::Ray<L>;

    /// Triangles from their three corners.
    fn triangle<L: Real>(self, corners: [Vec3<L>; 3]) -> Self::Triangle<L>;

    /// One triangle in all lanes: how it meets many rays after it was stored once.
    fn spread<L: Real>(one: &Self::Triangle<L::Scalar>) -> Self::Triangle<L>;

    /// Which lanes are hits, and their `t`, which is meaningless without a hit.
    fn test<L: Real>(self, triangle: &Self::Triangle<L>, ray: &Self::Ray<L>) -> (L::Mask, L);
}

/// One vector in all lanes.
#[inline(always)]
pub(super) fn splat<L: Real>(v: Vec3<L::Scalar>) -> Vec3<L> {
    Vec3::splat([v.x, v.y, v.z])
}

/// Three vectors in all lanes. (`map` of an array is not always inlined, and a function that is called
/// is compiled without the level's instructions: so it is spelled out here and in the tests.)
#[inline(always)]
pub(super) fn splat3<L: Real>([a, b, c]: [Vec3<L::Scalar>; 3]) -> [Vec3<L>; 3] {
    [splat(a), splat(b), splat(c)]
}

/// A ray for which nothing is computed in advance.
#[derive(Clone, Copy, Debug)]
pub struct PlainRay<L> {
    /// The point at `t = 0`.
    pub origin: Vec3<L>,
    /// The unit of `t`.
    pub dir: Vec3<L>,
}
