//! The test with Plücker coordinates (R. Jones, "Intersecting a ray and a triangle with Plücker
//! coordinates", Ray Tracing News 13(1), 2000). A line through `p` and `q` is the pair
//! `(q - p, p × q)`. The sign of the permuted product of two lines shows on which side one line
//! passes the other.
//!
//! The sides' Plücker coordinates are computed once, in scene coordinates. This makes the test fast
//! but less accurate, because the coordinates are not taken relative to the ray's origin.

use intertri::simd::Vec3;

use super::intersector::{Intersector, splat, splat3};
use super::real::Real;

/// The test with Plücker coordinates.
#[derive(Clone, Copy, Debug)]
pub struct Pluecker;

/// The line of a ray, as Plücker coordinates, and the ray's origin.
#[derive(Clone, Copy, Debug)]
pub struct Ray<L> {
    origin: Vec3<L>,
    dir: Vec3<L>,
    moment: Vec3<L>,
}

/// The lines of a triangle's sides, and its plane.
#[derive(Clone, Copy, Debug)]
pub struct Triangle<L> {
    sides: [Vec3<L>; 3],
    moments: [Vec3<L>; 3],
    n: Vec3<L>,
    d: L,
}

impl Intersector for Pluecker {
    type Ray<L: Real> = Ray<L>;
    type Triangle<L: Real> = Triangle<L>;

    #[inline(always)]
    fn ray<L: Real>(self, origin: Vec3<L>, dir: Vec3<L>) -> Ray<L> {
        // The moment is p × q for the points origin and origin + dir.
        Ray { origin, dir, moment: origin.cross(dir) }
    }

    #[inline(always)]
    fn triangle<L: Real>(self, [v0, v1, v2]: [Vec3<L>; 3]) -> Triangle<L> {
        let n = (v1 - v0).cross(v2 - v0);
        Triangle {
            sides: [v1 - v0, v2 - v1, v0 - v2],
            moments: [v0.cross(v1), v1.cross(v2), v2.cross(v0)],
            n,
            d: n.dot(v0),
        }
    }

    #[inline(always)]
    fn spread<L: Real>(one: &Triangle<L::Scalar>) -> Triangle<L> {
        let &Triangle { sides, moments, n, d } = one;
        Triangle { sides: splat3(sides), moments: splat3(moments), n: splat(n), d: L::splat(d) }
    }

    #[inline(always)]
    fn test<L: Real>(self, triangle: &Triangle<L>, ray: &Ray<L>) -> (L::Mask, L) {
        let zero = L::of(0.0);
        let hand = |k: usize| triangle.sides[k].dot(ray.moment) + triangle.moments[k].dot(ray.dir);
        let (u, v, w) = (hand(0), hand(1), hand(2));
        let same = (u.ge(zero) & v.ge(zero) & w.ge(zero)) | (u.le(zero) & v.le(zero) & w.le(zero));
        let t = (triangle.d - triangle.n.dot(ray.origin)) / triangle.n.dot(ray.dir);
        (same & t.gt(zero) & t.lt(L::of(f64::INFINITY)), t)
    }
}

#[cfg(test)]
mod tests {
    use intertri::simd::Vec3;

    use super::{Intersector, Pluecker};

    #[test]
    fn coordinates_by_hand() {
        let vec3 = |[x, y, z]: [f64; 3]| Vec3 { x, y, z };
        let plain = |v: Vec3<f64>| [v.x, v.y, v.z];
        let corners = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]].map(vec3);
        let triangle = Pluecker.triangle(corners);
        assert_eq!(
            triangle.sides.map(plain),
            [[-1.0, 1.0, 0.0], [0.0, -1.0, 1.0], [1.0, 0.0, -1.0]]
        );
        assert_eq!(
            triangle.moments.map(plain),
            [[0.0, 0.0, 1.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]
        );
        // The line through (1, 2, 3) and (1, 2, 3) + (0, 1, 0).
        let ray = Pluecker.ray(vec3([1.0, 2.0, 3.0]), vec3([0.0, 1.0, 0.0]));
        assert_eq!(plain(ray.moment), [-3.0, 0.0, 1.0]);
    }
}
