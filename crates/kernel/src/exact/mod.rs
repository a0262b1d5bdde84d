//! Exact arithmetic: results are correct for the coordinates as given, as long as all are finite.
//!
//! ```text
//!   A, B, C  the corners from the origin      closed   U, V, and W each are 0 or have T's sign.
//!   U = d·(B × C)                             once     A 0 takes the sign that it has if the
//!   V = d·(C × A)                                      direction is moved by (ε, ε², ε³).
//!   W = d·(A × B)
//!   T = A·(B × C)                             t = T / D > 0    u = V / D    v = W / D
//!   D = U + V + W
//! ```
//!
//! Only t, u, and v are rounded, once and at the end. Wherever an error bound permits, [`float`]
//! decides in f64; the remaining cases use the narrowest integers that suffice for the ray and the
//! triangle (see [`tier`]). `docs/numerics/exact.md` has the definitions, bounds, and proofs.

mod along;
mod area;
mod closest;
mod crossing;
mod decision;
mod direction_coefficients;
mod double;
mod eight_pairs;
mod facing;
mod float;
mod hit_coefficients;
mod input;
mod int;
mod interval;
mod numbers;
mod on_triangle;
mod one_pair;
mod pairs;
mod pairs64;
mod quotient;
mod rounded;
mod rounded32;
mod scale;
mod seen_edge;
mod seen_plane;
mod shared_edge;
mod shared_origin64;
mod spawn;
mod tails;
#[cfg(test)]
pub(crate) mod test_numbers;
mod tier;
mod wrapping;

pub(crate) use along::t_times_from;
pub use along::{attributes_from, attributes32, order_from, t_from};
pub use area::has_area;
pub use closest::{
    Closest, Feature, Squares, closer, closer_from, closest, feature, feature_from, squares,
};
pub use crossing::{crossing_from, decide_pair};
pub(crate) use decision::f32_bounds;
pub use decision::{PairDecision, Rule, Side};
pub use direction_coefficients::{DirectionCoefficients, DirectionCoefficients32};
pub use eight_pairs::EightPairs;
pub use facing::facing;
pub use float::{Decided, decide, decide_with_t};
pub use hit_coefficients::HitCoefficients;
pub use input::{is_plain, subnormals_are_read};
pub use on_triangle::is_on;
pub use pairs::hits_in;
pub(crate) use pairs::t_in;
pub use pairs64::{Pair64, hits64};
pub use rounded::Quotients;
pub use rounded32::{HitCoefficients32, hit32};
pub(crate) use rounded32::{hit32_alone, hits32_in};
pub use seen_edge::{edge_side, moment};
pub use seen_plane::SeenPlane;
pub use shared_origin64::hits_of_origin64;
pub use spawn::{spawn_ray, spawn_ray_to};
pub use tier::Tier;

use core::cmp::Ordering;

use decision::LIMITS;

use crate::simd::Vec3;
use crate::{RayOf, Scalar, TriangleOf};

/// Returns whether a ray meets a triangle within its interval. The rule determines which triangles
/// own a shared edge or corner.
pub fn hit<S: Scalar>(rule: Rule, ray: &RayOf<S>, triangle: &TriangleOf<S>) -> bool {
    crossing_from(Tier::Float, rule, ray, triangle).is_some()
}

/// Returns the side from which a ray crosses a triangle within its interval, if it does. Each point
/// of a mesh belongs to exactly one of its triangles.
pub fn crossing<S: Scalar>(ray: &RayOf<S>, triangle: &TriangleOf<S>) -> Option<Side> {
    crossing_from(Tier::Float, Rule::Once, ray, triangle)
}

/// Returns the order in which a ray meets two triangles, if no exact quotient is needed to determine
/// it: their coordinates alone tell, bounds on both values of t do not overlap, or the ray passes
/// through a corner or edge that the triangles share. The result is meaningless unless the ray hits
/// both.
pub fn known_order<S: Scalar>(
    ray: &RayOf<S>,
    one: &TriangleOf<S>,
    other: &TriangleOf<S>,
) -> Option<Ordering> {
    // Coplanar walls and floors are common, and a ray often meets two neighbours at a shared edge.
    order_by_coordinates(ray, one, other)
        .or_else(|| order_by_bounds(ray, one, other))
        .or_else(|| shared_edge::is_met(ray, one, other).then_some(Ordering::Equal))
}

/// Returns the order in which a ray meets the planes of two triangles, if f64 and its error bounds
/// suffice.
fn order_by_bounds<S: Scalar>(
    ray: &RayOf<S>,
    one: &TriangleOf<S>,
    other: &TriangleOf<S>,
) -> Option<Ordering> {
    let vec3 = |v: [S; 3]| Vec3::<f64>::splat(v.map(Into::into));
    let bounds = |triangle: &TriangleOf<S>| {
        let corners = triangle.0.map(vec3);
        let [lo, hi] = float::bounds_on_t(corners, vec3(ray.origin), vec3(ray.dir))?;
        (is_plain(ray, triangle) && lo >= LIMITS[0] && hi <= LIMITS[1]).then_some([lo, hi])
    };
    let ([lo, hi], [other_lo, other_hi]) = (bounds(one)?, bounds(other)?);
    let order = if hi < other_lo { Ordering::Less } else { Ordering::Greater };
    (hi < other_lo || other_hi < lo).then_some(order)
}

/// Returns whether the corner or the edge on which a ray meets one triangle also belongs to another.
/// If the ray hits both, t is then the same. `edges` tells on which edges the ray is known to meet
/// the first one ([`PairDecision::Hit`]); at least one bit must be set.
pub fn shares_feature<S: Scalar>(one: &TriangleOf<S>, edges: u8, other: &TriangleOf<S>) -> bool {
    shared_edge::has_feature(other, one, edges)
}

/// Returns the correctly rounded t of a triangle whose plane the ray's line meets in exactly one
/// point.
pub fn t<S: Scalar>(ray: &RayOf<S>, triangle: &TriangleOf<S>) -> f64 {
    t_from(Tier::Float, ray, triangle)
}

/// Returns the correctly rounded `t * 2^exponent` for a triangle whose plane the ray's line meets
/// in exactly one point.
pub fn t_times<S: Scalar>(ray: &RayOf<S>, triangle: &TriangleOf<S>, exponent: i32) -> f64 {
    t_times_from(Tier::Float, ray, triangle, exponent)
}

/// Returns whether a ray's interval is not empty.
pub(crate) fn has_interval<S: Scalar>(ray: &RayOf<S>) -> bool {
    interval::Interval::of(ray).is_some()
}

/// Returns the correctly rounded t, u, and v of a triangle whose plane the ray's line meets in
/// exactly one point.
pub fn attributes<S: Scalar>(ray: &RayOf<S>, triangle: &TriangleOf<S>) -> (f64, f64, f64) {
    attributes_from(Tier::Float, ray, triangle)
}

/// Returns the exact order in which a ray meets two triangles. The ray's line must meet each plane
/// in exactly one point.
pub fn order<S: Scalar>(ray: &RayOf<S>, one: &TriangleOf<S>, other: &TriangleOf<S>) -> Ordering {
    if let Some(order) = known_order(ray, one, other) {
        return order;
    }
    // If the rounded values of t differ, their order is the exact one. For f32, integers are nearly
    // as fast, so the rounded values are not tried.
    if const { tier::is_f64::<S>() } {
        let rounded = t(ray, one).total_cmp(&t(ray, other));
        if rounded.is_ne() {
            return rounded;
        }
    }
    order_from(Tier::Float, ray, one, other)
}

/// Returns the exact order in which a ray meets two triangles, if their coordinates alone tell:
/// both are perpendicular to the same axis, as walls and floors often are, or both have the same
/// corners. The ray's line must meet each plane in exactly one point.
pub fn order_by_coordinates<S: Scalar>(
    ray: &RayOf<S>,
    one: &TriangleOf<S>,
    other: &TriangleOf<S>,
) -> Option<Ordering> {
    let across_axis = (0..3).find_map(|axis| {
        let order = position(one, axis)?.cmp(&position(other, axis)?);
        Some(if ray.dir[axis].is_negative() { order.reverse() } else { order })
    });
    across_axis.or_else(|| shared_edge::is_all(one, other).then_some(Ordering::Equal))
}

/// Returns the position of a triangle's plane on an axis perpendicular to it, as an integer that
/// orders coordinates, or `None` if the axis is not perpendicular.
fn position<S: Scalar>(triangle: &TriangleOf<S>, axis: usize) -> Option<i64> {
    let [a, b, c] = triangle.0.map(|corner| {
        let rank = corner[axis].rank() as i64;
        if corner[axis].is_negative() { -rank } else { rank }
    });
    (a == b && b == c).then_some(a)
}

#[cfg(test)]
mod tests {
    use core::cmp::Ordering;

    use super::test_numbers::random;
    use super::{Tier, known_order, order_by_bounds, order_from};
    use crate::{RayOf, Scalar, TriangleOf};

    /// Compares the order of two planes whose values of t differ by up to `apart` with integers.
    fn bounds_know_the_order<S: Scalar>(apart: f64) -> [u32; 2] {
        let (mut random, mut counts) = (random(), [0; 2]);
        for i in 0..20_000 {
            let mut vec3 = || [0; 3].map(|_| random());
            let (origin, dir) = (vec3(), vec3());
            // The ray meets both triangles inside, at the same t but for a small distance.
            let mut through = |t: f64| {
                let [a, b] = [vec3(), vec3()];
                let at = |p: &[f64; 3], k: usize| S::nearest(origin[k] + t * dir[k] + p[k]);
                let c = [0, 1, 2].map(|k| -a[k] - b[k]);
                TriangleOf([a, b, c].map(|p| [0, 1, 2].map(|k| at(&p, k))))
            };
            let (one, other) = (through(1.0), through(1.0 + apart * f64::from(i % 8)));
            let [origin, dir] = [origin, dir].map(|v| v.map(S::nearest));
            let ray = RayOf { origin, t_min: S::ZERO, dir, t_max: S::INFINITY };
            let truth = order_from(Tier::Narrow, &ray, &one, &other);
            if let Some(order) = order_by_bounds(&ray, &one, &other) {
                assert_eq!(order, truth, "{ray:?} {one:?} {other:?}");
                assert_eq!(known_order(&ray, &one, &other), Some(order));
                counts[usize::from(order == Ordering::Less)] += 1;
            }
        }
        counts
    }

    #[test]
    fn bounds_on_t_know_the_order() {
        for (apart, least) in [(1e-13, 5000), (1e-15, 100)] {
            let [_, less] = bounds_know_the_order::<f64>(apart);
            assert!(less >= least, "{apart}: {less}");
        }
        let [more, less] = bounds_know_the_order::<f32>(1e-7);
        assert!(more > 1000 && less > 5000, "{more} {less}");
    }
}
