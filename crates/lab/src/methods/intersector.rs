//! The interface that every ray/triangle test implements, generic over the lane type.

use intertri::simd::Vec3;

use super::real::Real;

/// A ray/triangle test, with its own prepared forms of rays and triangles.
pub trait Intersector: Copy {
    /// A ray and the values computed once for it.
    type Ray<L: Real>: Copy;
    /// A triangle and the values computed once for it.
    type Triangle<L: Real>: Copy;

    /// Prepares rays from their origins and directions.
    fn ray<L: Real>(self, origin: Vec3<L>, dir: Vec3<L>) -> Self::Ray<L>;

    /// Prepares triangles from their three corners.
    fn triangle<L: Real>(self, corners: [Vec3<L>; 3]) -> Self::Triangle<L>;

    /// Copies one triangle to all lanes, to test a stored triangle against many rays.
    fn spread<L: Real>(one: &Self::Triangle<L::Scalar>) -> Self::Triangle<L>;

    /// Tests rays against triangles. Returns a mask of the lanes that hit, and `t`, which is
    /// meaningless in the other lanes.
    fn test<L: Real>(self, triangle: &Self::Triangle<L>, ray: &Self::Ray<L>) -> (L::Mask, L);
}

/// Copies one vector to all lanes.
#[inline(always)]
pub(super) fn splat<L: Real>(v: Vec3<L::Scalar>) -> Vec3<L> {
    Vec3::splat([v.x, v.y, v.z])
}

/// Copies three vectors to all lanes. An array's `map` is not always inlined, and a function that
/// is not inlined is compiled without the level's instructions, so the calls are written out here
/// and in the tests.
#[inline(always)]
pub(super) fn splat3<L: Real>([a, b, c]: [Vec3<L::Scalar>; 3]) -> [Vec3<L>; 3] {
    [splat(a), splat(b), splat(c)]
}

/// A ray without precomputed values.
#[derive(Clone, Copy, Debug)]
pub struct PlainRay<L> {
    /// The point at `t = 0`.
    pub origin: Vec3<L>,
    /// The direction, whose length is the unit of `t`.
    pub dir: Vec3<L>,
}
