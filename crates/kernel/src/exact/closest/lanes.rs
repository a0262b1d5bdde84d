//! Bounds on squared distances in f64, with one triangle per lane.
//!
//! ```text
//!   to the plane  <=  to the triangle  <=  to the nearest edge       always
//!   to the plane   =  to the triangle                                where the point is certainly above it
//!                     to the triangle   =  to the nearest edge       where it certainly is not
//! ```

use crate::simd::{Lanes, Vec3};

/// Lower and upper bounds on the squared distances of the triangles in the lanes.
#[derive(Clone, Copy)]
pub struct Squares<D: Lanes> {
    /// The lower bound on the squared distance of each triangle.
    pub least: D,
    /// The upper bound on the squared distance of each triangle.
    pub most: D,
}

/// `2^-29`: a bound on the relative error of squared distances. [`PLACE`] bounds an additional
/// error.
const SHARE: f64 = 1.0 / (1_u64 << 29) as f64;

/// `2^-64`: a bound on the additional error of squared distances, relative to the squared distance
/// of the farthest corner.
const PLACE: f64 = SHARE * SHARE / 64.0;

/// `2^-200`: a bound on how much a squared distance changes if the CPU reads subnormal numbers as
/// 0.
const TINY: f64 = f64::from_bits((1023 - 200) << 52);

/// `2^-48`: it is certain on which side of an edge the point is if the magnitude of the edge's
/// value exceeds this fraction of the cube of the longest edge times the distance to the edge's
/// start.
const SIDE: f64 = 1.0 / (1_u64 << 48) as f64;

/// `2^-60`: if a triangle's longest edge is no longer than this, only the distance to the edges is
/// computed, as an upper bound.
const SHORTEST: f64 = 1.0 / (1_u64 << 60) as f64;

/// `2^-104`: if a triangle's squared normal is at most this fraction of the fourth power of its
/// longest edge, the triangle counts as flat, and its edges are as near as the triangle itself.
const FLAT: f64 = f64::from_bits((1023 - 104) << 52);

/// Bounds the squared distances from a point to finite triangles, which may also be segments or
/// points.
#[inline(always)]
pub fn squares<D: Lanes<Scalar = f64>>(corners: [Vec3<D>; 3], point: Vec3<D>) -> Squares<D> {
    let [a, b, c] = [corners[0] - point, corners[1] - point, corners[2] - point];
    let edges = [corners[1] - corners[0], corners[2] - corners[1], corners[0] - corners[2]];
    let farthest = a.dot_fused(a).max(b.dot_fused(b)).max(c.dot_fused(c));

    // Compute the distances to the edges.
    let [x, y, z] = [to_edge(a, edges[0]), to_edge(b, edges[1]), to_edge(c, edges[2])];
    let edge = x.min(y).min(z);

    // Compute the distance to the plane.
    let normal = edges[0].cross_fused(edges[1]);
    let square = normal.dot_fused(normal);
    let volume = a.dot_fused(normal);
    let inverse = D::splat(1.0) / square;
    let plane = (volume * volume) * inverse;

    // Find the side of each edge that the point is on.
    let length = edges[0].norm1().max(edges[1].norm1()).max(edges[2].norm1());
    let fourth = (length * length) * (length * length);
    let known = length.gt(D::splat(SHORTEST));
    let bound = (length * D::splat(SIDE)) * (length * length);
    let (ab_out, ab_in) = side(normal, a, edges[0], bound);
    let (bc_out, bc_in) = side(normal, b, edges[1], bound);
    let (ca_out, ca_in) = side(normal, c, edges[2], bound);
    let outside = known & (ab_out | bc_out | ca_out);
    let inside = known & ab_in & bc_in & ca_in;

    let (less, more) = (D::splat(1.0 - SHARE), D::splat(1.0 + SHARE));
    let edge_doubt = farthest.mul_add(D::splat(PLACE), D::splat(TINY));
    let plane_doubt = (farthest * D::splat(PLACE)).mul_add(fourth * inverse, D::splat(TINY));
    let none = D::splat(0.0);
    // If the projection of the point is certainly outside the face, or if the triangle is flat, the
    // distance equals the distance to the nearest edge. Otherwise, the plane gives a lower bound.
    let beside = outside | square.le(fourth * D::splat(FLAT));
    let least = D::select(beside, edge * less - edge_doubt, plane * less - plane_doubt);
    // If a triangle is a point, its edges are also as near as the triangle. If a square overflows,
    // which takes a point about 2^500 times as far away as the mesh is large, nothing is known.
    let bounded = (known | length.le(none)) & least.lt(D::splat(f64::INFINITY));
    let least = D::select(bounded & least.ge(none), least, none);
    let (most, above) = (edge * more + edge_doubt, plane * more + plane_doubt);
    // Upper bounds may be combined freely, because each is the distance to some point on the
    // triangle.
    let most = D::select(inside & above.lt(most), above, most);
    Squares { least, most }
}

/// Returns the squared distance to an edge that starts at a corner.
#[inline(always)]
fn to_edge<D: Lanes<Scalar = f64>>(corner: Vec3<D>, edge: Vec3<D>) -> D {
    let (none, all) = (D::splat(0.0), D::splat(1.0));
    // Find the foot of the perpendicular on the edge's line, clamped to the edge. If the edge has
    // length 0, the foot's position is NaN, which is replaced by 0: the corner itself.
    let share = -corner.dot_fused(edge) / edge.dot_fused(edge);
    // A comparison with NaN is false, so NaN becomes 0.
    let share = D::select(share.ge(none), share, none);
    let share = D::select(share.le(all), share, all);
    let to = Vec3 {
        x: share.mul_add(edge.x, corner.x),
        y: share.mul_add(edge.y, corner.y),
        z: share.mul_add(edge.z, corner.z),
    };
    to.dot_fused(to)
}

/// Returns the lanes in which the point is certainly outside an edge that starts at a corner, and
/// those in which it certainly is not, as seen along a normal.
#[inline(always)]
fn side<D: Lanes<Scalar = f64>>(
    normal: Vec3<D>,
    corner: Vec3<D>,
    edge: Vec3<D>,
    bound: D,
) -> (D::Mask, D::Mask) {
    let side = normal.cross_fused(edge).dot_fused(corner);
    let bound = bound * corner.norm1();
    (side.gt(bound), side.lt(-bound))
}
