//! Badouel's test (D. Badouel, "An efficient ray-polygon intersection", Graphics Gems, 1990). It
//! first intersects the ray with the triangle's plane, then computes two weights in the coordinate
//! plane onto which the triangle's projection is largest.
//!
//! I. Wald's precomputed variant ("Realtime ray tracing and interactive global illumination",
//! thesis, Saarland University, 2004) uses the same arithmetic as
//! [`baldwin_weber`](super::baldwin_weber).

use intertri::simd::Lanes;
use intertri::simd::Vec3;

use super::axis::Axis;
use super::intersector::{Intersector, PlainRay, splat};
use super::real::Real;

/// Badouel's test.
#[derive(Clone, Copy, Debug)]
pub struct Badouel;

/// The triangle's plane, and the triangle projected along the longest axis of the normal.
#[derive(Clone, Copy)]
pub struct Triangle<L: Lanes> {
    n: Vec3<L>,
    d: L,
    axis: Axis<L::Mask>,
    corner: [L; 2],
    /// The projected sides from `corner`, divided by twice the projected area.
    sides: [[L; 2]; 2],
}

impl Intersector for Badouel {
    type Ray<L: Real> = PlainRay<L>;
    type Triangle<L: Real> = Triangle<L>;

    #[inline(always)]
    fn ray<L: Real>(self, origin: Vec3<L>, dir: Vec3<L>) -> PlainRay<L> {
        PlainRay { origin, dir }
    }

    #[inline(always)]
    fn triangle<L: Real>(self, [v0, v1, v2]: [Vec3<L>; 3]) -> Triangle<L> {
        let (e1, e2) = (v1 - v0, v2 - v0);
        let n = e1.cross(e2);
        let axis = Axis::longest(n);
        let area = axis.turn(n).z;
        let (corner, e1, e2) = (axis.turn(v0), axis.turn(e1), axis.turn(e2));
        Triangle {
            n,
            d: n.dot(v0),
            axis,
            corner: [corner.x, corner.y],
            sides: [[e1.x / area, e1.y / area], [e2.x / area, e2.y / area]],
        }
    }

    #[inline(always)]
    fn spread<L: Real>(one: &Triangle<L::Scalar>) -> Triangle<L> {
        let &Triangle { n, d, axis, corner: [x, y], sides: [[ax, ay], [bx, by]] } = one;
        Triangle {
            n: splat(n),
            d: L::splat(d),
            axis: axis.spread(),
            corner: [L::splat(x), L::splat(y)],
            sides: [[L::splat(ax), L::splat(ay)], [L::splat(bx), L::splat(by)]],
        }
    }

    #[inline(always)]
    fn test<L: Real>(self, triangle: &Triangle<L>, ray: &PlainRay<L>) -> (L::Mask, L) {
        let &Triangle { n, d, axis, corner, sides: [[ax, ay], [bx, by]] } = triangle;
        let (zero, one) = (L::of(0.0), L::of(1.0));

        // Compute the hit point relative to the first corner, projected along the axis.
        let t = (d - n.dot(ray.origin)) / n.dot(ray.dir);
        let (o, dir) = (axis.turn(ray.origin), axis.turn(ray.dir));
        let x = o.x + dir.x * t - corner[0];
        let y = o.y + dir.y * t - corner[1];

        // (x, y) = u a + v b, where a and b are the sides.
        let u = x * by - y * bx;
        let v = y * ax - x * ay;
        (u.ge(zero) & v.ge(zero) & (u + v).le(one) & t.gt(zero), t)
    }
}

#[cfg(test)]
mod tests {
    use intertri::simd::Vec3;

    use super::{Axis, Badouel, Intersector};

    #[test]
    fn the_projection_by_hand() {
        // The triangle is in the plane y = 2. Projected along y, with z to the right and x up,
        // twice its area is 6.
        let corners = [[1.0, 2.0, 1.0], [3.0, 2.0, 1.0], [1.0, 2.0, 4.0]];
        let triangle = Badouel.triangle(corners.map(|[x, y, z]: [f64; 3]| Vec3 { x, y, z }));
        assert!(matches!(triangle.axis, Axis::Same(1)));
        assert_eq!([triangle.n.x, triangle.n.y, triangle.n.z, triangle.d], [0.0, -6.0, 0.0, -12.0]);
        assert_eq!(triangle.corner, [1.0, 1.0]);
        assert_eq!(triangle.sides, [[0.0, 2.0 / -6.0], [3.0 / -6.0, 0.0]]);
    }
}
