//! The test by Baldwin and Weber (D. Baldwin and M. Weber, "Fast ray-triangle intersections by
//! coordinate transformation", Journal of Computer Graphics Techniques 5(3), 2016). The method uses
//! an affine map that takes the triangle's corners to (0,0), (1,0), and (0,1) in the plane z = 0.
//!
//! One column of the map can be chosen freely; the choice below avoids division by a small number.
//! If `k` is the longest axis of the normal, `i` and `j` are the next two axes, and `f1` and `f2`
//! are the sides, the rows are
//!
//! ```text
//!   row 1   f2_j / n_k   at i    -f2_i / n_k   at j    0   at k     (v2 × v0)_k / n_k
//!   row 2  -f1_j / n_k   at i     f1_i / n_k   at j    0   at k    -(v1 × v0)_k / n_k
//!   row 3    n_i / n_k   at i      n_j / n_k   at j    1   at k     -(n · v0) / n_k
//! ```

use intertri::simd::Vec3;

use super::axis::Axis;
use super::intersector::{Intersector, PlainRay, splat3};
use super::real::Real;

/// The test by Baldwin and Weber. It stores the full 3×4 matrix, so the test does not need a branch
/// on the axis.
#[derive(Clone, Copy, Debug)]
pub struct BaldwinWeber;

/// The affine map, as three rows and their constants.
#[derive(Clone, Copy, Debug)]
pub struct Triangle<L> {
    rows: [Vec3<L>; 3],
    constants: [L; 3],
}

impl Intersector for BaldwinWeber {
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
        let (zero, one) = (L::of(0.0), L::of(1.0));

        // Compute the rows in permuted axes and permute them back. Three cyclic permutations are
        // the identity, so two more undo the first.
        let back = |x: L, y: L, z: L| axis.turn(axis.turn(Vec3 { x, y, z }));
        let (turned, f1, f2) = (axis.turn(n), axis.turn(e1), axis.turn(e2));
        let k = turned.z;
        Triangle {
            rows: [
                back(f2.y / k, -f2.x / k, zero),
                back(-f1.y / k, f1.x / k, zero),
                back(turned.x / k, turned.y / k, one),
            ],
            constants: [
                axis.turn(v2.cross(v0)).z / k,
                -axis.turn(v1.cross(v0)).z / k,
                -n.dot(v0) / k,
            ],
        }
    }

    #[inline(always)]
    fn spread<L: Real>(one: &Triangle<L::Scalar>) -> Triangle<L> {
        let &Triangle { rows, constants: [a, b, c] } = one;
        Triangle { rows: splat3(rows), constants: [L::splat(a), L::splat(b), L::splat(c)] }
    }

    #[inline(always)]
    fn test<L: Real>(self, triangle: &Triangle<L>, ray: &PlainRay<L>) -> (L::Mask, L) {
        let &Triangle { rows: [row1, row2, row3], constants: [c1, c2, c3] } = triangle;
        let (zero, one) = (L::of(0.0), L::of(1.0));

        // Compute the t at which the third coordinate becomes 0, and the other two coordinates at
        // that t.
        let t = -(row3.dot(ray.origin) + c3) / row3.dot(ray.dir);
        let point = ray.origin + ray.dir * t;
        let u = row1.dot(point) + c1;
        let v = row2.dot(point) + c2;
        (u.ge(zero) & v.ge(zero) & (u + v).le(one) & t.gt(zero), t)
    }
}

#[cfg(test)]
mod tests {
    use intertri::simd::Vec3;

    use super::{BaldwinWeber, Intersector};

    #[test]
    fn the_map_takes_the_corners_where_the_paper_wants_them() {
        // In each turn, a different axis is the longest axis of the normal.
        for turn in 0..3 {
            let corners = [[2.0, 3.0, 4.0], [6.0, 3.0, 5.0], [4.0, 9.0, 4.0]];
            let corners: [Vec3<f64>; 3] = corners.map(|p: [f64; 3]| {
                let at = |k: usize| p[(k + turn) % 3];
                Vec3 { x: at(0), y: at(1), z: at(2) }
            });
            let map = BaldwinWeber.triangle(corners);
            for (corner, place) in
                corners.into_iter().zip([[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]])
            {
                for (k, wanted) in place.into_iter().enumerate() {
                    let got = map.rows[k].dot(corner) + map.constants[k];
                    assert!((got - wanted).abs() < 1e-14, "{turn} {k}: {got} {wanted}");
                }
            }
        }
    }
}
