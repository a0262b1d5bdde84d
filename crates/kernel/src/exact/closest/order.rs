//! Decides exactly which of two triangles is closer to a point.

use core::cmp::Ordering;

use super::super::int::{Int, cross, dot};
use super::super::scale::Scale;
use super::super::tier::Tier;
use super::feature::{Feature, feature_from};
use super::offsets::{Offsets, Points, at_widths, points};
use crate::{Scalar, TriangleOf};

/// Compares the distances of two finite triangles from a finite point.
pub fn closer<S: Scalar>(point: [S; 3], one: &TriangleOf<S>, other: &TriangleOf<S>) -> Ordering {
    closer_from(Tier::Float, point, one, other)
}

/// Like [`closer()`], but the computation starts at the given tier.
pub fn closer_from<S: Scalar>(
    from: Tier,
    point: [S; 3],
    one: &TriangleOf<S>,
    other: &TriangleOf<S>,
) -> Ordering {
    let features = [one, other].map(|triangle| feature_from(from, point, triangle));

    // Adjacent triangles share corners and edges. If both closest points are on the same corner or
    // edge, both squared distances are the same quotient, so no integers are needed.
    if from == Tier::Float && is_same(features, [one, other]) {
        return Ordering::Equal;
    }
    by_integers(from, &[one, other].map(|triangle| points(point, triangle)), features)
}

#[cold]
#[inline(never)]
fn by_integers(from: Tier, points: &[Points; 2], features: [Feature; 2]) -> Ordering {
    let scale = Scale::of(points.as_flattened());
    at_widths!(from.max(scale.tier()), exactly(scale, points, features))
}

/// Returns whether both closest points are on the same corner or edge.
#[inline(always)]
fn is_same<S: Scalar>(features: [Feature; 2], [one, other]: [&TriangleOf<S>; 2]) -> bool {
    let corner = |of: &TriangleOf<S>, i: usize| of.0[i % 3].map(S::key);
    match features {
        [Feature::Corner(i), Feature::Corner(j)] => corner(one, i) == corner(other, j),
        [Feature::Edge(i), Feature::Edge(j)] => {
            let (a, b) = (corner(one, i), corner(one, i + 1));
            let (c, d) = (corner(other, j), corner(other, j + 1));
            (a == c && b == d) || (a == d && b == c)
        }
        _ => false,
    }
}

fn exactly<
    const C: usize,
    const N: usize,
    const T: usize,
    const Q: usize,
    const V: usize,
    const P: usize,
>(
    scale: Scale,
    points: &[Points; 2],
    features: [Feature; 2],
) -> Ordering {
    let square = |i: usize| {
        let offsets = Offsets::<C, N>::new(scale, points[i]);
        square::<C, N, T, Q, V>(&offsets, features[i])
    };
    let ((num, den), (other_num, other_den)) = (square(0), square(1));
    // Denominators are positive, so cross-multiplying preserves the order.
    num.times::<Q, P>(&other_den).cmp(&other_num.times(&den))
}

/// Returns the squared distance as a numerator and a positive denominator.
#[inline(always)]
pub(super) fn square<
    const C: usize,
    const N: usize,
    const T: usize,
    const Q: usize,
    const V: usize,
>(
    offsets: &Offsets<C, N>,
    feature: Feature,
) -> (Int<V>, Int<Q>) {
    match feature {
        Feature::Corner(i) => {
            let corner = &offsets.corners[i];
            (dot::<C, C, N>(corner, corner).widened(), Int::new(1, 0))
        }
        Feature::Edge(i) => {
            let edge = offsets.edge(i);
            let area: [Int<N>; 3] = cross(&offsets.corners[i], &edge);
            // |corner × edge|² / |edge|²
            (dot::<N, N, Q>(&area, &area).widened(), dot::<C, C, N>(&edge, &edge).widened())
        }
        Feature::Face => {
            let [ab, ac] = &offsets.sides;
            let normal: [Int<N>; 3] = cross(ab, ac);
            let volume: Int<T> = dot(&offsets.corners[0], &normal);
            (volume.times(&volume), dot(&normal, &normal))
        }
    }
}
