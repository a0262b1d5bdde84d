//! The distance and position of the closest point on a triangle, each rounded from its exact value.

use super::super::int::Int;
use super::super::quotient::Quotient;
use super::super::scale::Scale;
use super::super::tier::Tier;
use super::closest_point::Closest;
use super::feature::{Feature, feature_from, is_tame};
use super::offsets::{Offsets, Points, at_widths, points};
use super::order::square;
use super::rounded;
use crate::{Scalar, TriangleOf};

/// Returns the point on a finite triangle that is closest to a finite point. The computation starts
/// at the given tier.
pub fn closest<S: Scalar>(from: Tier, point: [S; 3], triangle: &TriangleOf<S>) -> Closest {
    let feature = feature_from(from, point, triangle);
    if from == Tier::Float
        && is_tame(point, triangle)
        && let Some(closest) = rounded::closest(point, triangle, feature)
    {
        return closest;
    }
    by_integers(from, points(point, triangle), feature)
}

#[cold]
#[inline(never)]
fn by_integers(from: Tier, points: Points, feature: Feature) -> Closest {
    let scale = Scale::of(&points);
    at_widths!(from.max(scale.tier()), exactly(scale, points, feature))
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
    feature: Feature,
) -> Closest {
    let offsets = Offsets::<C, N>::new(scale, points);
    let (num, den) = square::<C, N, T, Q, V>(&offsets, feature);
    let distance = if num.sign().is_eq() {
        0.0
    } else {
        // The squared length is in units of (2^low)², so the exponent is doubled.
        Quotient::new(&num.size(), &den.widened::<V>().size(), 2 * scale.low).to_sqrt()
    };

    let [e1, e2, e3, e4, e5, e6] = offsets.along();
    let weights = match feature {
        Feature::Corner(corner) => [1, 2].map(|other| if corner == other { 1.0 } else { 0.0 }),
        // The edges run from a to b, from b to c, and from c to a.
        Feature::Edge(0) => [share(e1, e3 - e1), 0.0],
        Feature::Edge(1) => {
            let (of_b, of_c) = (e6 - e5, e3 - e4);
            [share(of_b, of_b + of_c), share(of_c, of_b + of_c)]
        }
        Feature::Edge(_) => [0.0, share(e2, e6 - e2)],
        Feature::Face => {
            let area = |a: Int<N>, b: Int<N>, c: Int<N>, d: Int<N>| -> Int<Q> {
                a.times(&b) - c.times(&d)
            };
            [share(area(e5, e2, e1, e6), den), share(area(e1, e4, e3, e2), den)]
        }
    };
    Closest { distance, weights }
}

/// Returns the correctly rounded magnitude of a quotient of two integers.
#[inline(always)]
fn share<const N: usize>(num: Int<N>, den: Int<N>) -> f64 {
    if num.sign().is_eq() { 0.0 } else { Quotient::new(&num.size(), &den.size(), 0).to_f64() }
}
