//! Finds the part of a triangle that contains the closest point, after Ericson, *Real-Time
//! Collision Detection*, 2005, section 5.1.5, with exact signs.

use core::cmp::Ordering;

use super::super::input::is_plain;
use super::super::int::Int;
use super::super::scale::Scale;
use super::super::tier::Tier;
use super::offsets::{Offsets, Points, at_widths, points};
use crate::{RayOf, Scalar, TriangleOf};

/// The part of a triangle that contains the closest point.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Feature {
    /// The corner 0, 1 or 2.
    Corner(usize),
    /// The interior of the edge from this corner to the next.
    Edge(usize),
    /// The interior of the triangle.
    Face,
}

/// `2^-50`: a bound on the error of a dot product in f64, relative to the sum of the magnitudes of
/// its products.
const SUM: f64 = 4.0 * f64::EPSILON;

/// `2^-48`: the corresponding bound for products of two dot products, relative to the products of
/// both sums.
const AREA: f64 = 16.0 * f64::EPSILON;

/// Returns whether rounding is the only error of f64 arithmetic on these coordinates.
#[inline(always)]
pub(super) fn is_tame<S: Scalar>(point: [S; 3], triangle: &TriangleOf<S>) -> bool {
    is_plain(&RayOf::new(point, [S::ONE, S::ZERO, S::ZERO]), triangle)
}

/// Returns the part of a finite triangle that contains the point closest to a finite point. If the
/// triangle is a segment or a point, the part is a corner or an edge of nonzero length.
pub fn feature<S: Scalar>(point: [S; 3], triangle: &TriangleOf<S>) -> Feature {
    feature_from(Tier::Float, point, triangle)
}

/// Like [`feature()`], but the computation starts at the given tier.
pub fn feature_from<S: Scalar>(from: Tier, point: [S; 3], triangle: &TriangleOf<S>) -> Feature {
    if from == Tier::Float
        && is_tame(point, triangle)
        && let Some(feature) = by_float(point, triangle)
    {
        return feature;
    }
    by_integers(from, points(point, triangle))
}

#[cold]
#[inline(never)]
fn by_integers(from: Tier, points: Points) -> Feature {
    let scale = Scale::of(&points);
    at_widths!(from.max(scale.tier()), exactly(scale, points))
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
    points: Points,
) -> Feature {
    let offsets = Offsets::<C, N>::new(scale, points);
    let along = offsets.along();
    let area = |a: usize, b: usize, c: usize, d: usize| -> Int<Q> {
        along[a].times(&along[b]) - along[c].times(&along[d])
    };
    // Exact signs are always known, so `find` always succeeds here.
    let found = find(
        |i| Some(along[i].sign()),
        |i, j| Some((along[i] - along[j]).sign()),
        |[a, b, c, d]| Some(area(a, b, c, d).sign()),
    );
    found.unwrap_or(Feature::Face)
}

/// Finds the feature in f64, if all necessary values exceed their error bounds.
#[inline(always)]
fn by_float<S: Scalar>(point: [S; 3], triangle: &TriangleOf<S>) -> Option<Feature> {
    let p = point.map(Into::into);
    let minus = |a: [f64; 3], b: [f64; 3]| [a[0] - b[0], a[1] - b[1], a[2] - b[2]];
    let corners = triangle.0.map(|corner| corner.map(Into::into));
    let [a, b, c] = corners;
    let (ab, ac) = (minus(b, a), minus(c, a));

    // Each value comes with the sum of the magnitudes of its products, to which its error is
    // relative.
    let dot = |x: [f64; 3], y: [f64; 3]| {
        let [a, b, c] = [x[0] * y[0], x[1] * y[1], x[2] * y[2]];
        ((a + b) + c, (a.abs() + b.abs()) + c.abs())
    };
    let offsets = corners.map(|corner| minus(corner, p));
    let [a, b, c] = offsets;
    let along = [dot(ab, a), dot(ac, a), dot(ab, b), dot(ac, b), dot(ab, c), dot(ac, c)];
    // If all products are 0, so is the value.
    let sign = |x: f64, bound: f64| {
        let sure = x.abs() > bound || bound == 0.0;
        sure.then(|| x.partial_cmp(&0.0)).flatten()
    };
    find(
        |i| sign(along[i].0, along[i].1 * SUM),
        |i, j| sign(along[i].0 - along[j].0, (along[i].1 + along[j].1) * SUM),
        |[a, b, c, d]| {
            let [a, b, c, d] = [along[a], along[b], along[c], along[d]];
            sign(a.0 * b.0 - c.0 * d.0, (a.1 * b.1 + c.1 * d.1) * AREA)
        },
    )
}

/// Finds the feature from the signs of the six products `along`, of the differences of two such
/// products, and of `xy - zw` for four such products. Returns `None` if a necessary sign is
/// unknown.
#[inline(always)]
fn find(
    sign: impl Fn(usize) -> Option<Ordering>,
    minus: impl Fn(usize, usize) -> Option<Ordering>,
    area: impl Fn([usize; 4]) -> Option<Ordering>,
) -> Option<Feature> {
    // Test the corners. A corner is the closest point if neither of its edges leads toward the
    // query point, which is then in the cone of the corner's normals.
    let signs = [sign(0)?, sign(1)?, sign(2)?, sign(3)?, sign(4)?, sign(5)?];
    if signs[0].is_ge() && signs[1].is_ge() {
        return Some(Feature::Corner(0));
    }
    if signs[2].is_le() && minus(3, 2)?.is_ge() {
        return Some(Feature::Corner(1));
    }
    if signs[5].is_le() && minus(4, 5)?.is_ge() {
        return Some(Feature::Corner(2));
    }

    // Test the edges. The query point must be outside the edge and strictly between its ends, so an
    // edge of length 0 is never chosen.
    if signs[0].is_lt() && signs[2].is_gt() && area([0, 3, 2, 1])?.is_le() {
        return Some(Feature::Edge(0));
    }
    if signs[1].is_lt() && signs[5].is_gt() && area([4, 1, 0, 5])?.is_le() {
        return Some(Feature::Edge(2));
    }
    if area([2, 5, 4, 3])?.is_le() && minus(2, 3)?.is_gt() && minus(5, 4)?.is_gt() {
        return Some(Feature::Edge(1));
    }
    Some(Feature::Face)
}
