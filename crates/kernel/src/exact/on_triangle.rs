//! Tests whether a point lies on a triangle.

use super::input::is_finite;
use super::numbers::{Numbers, Pair};
use super::scale::Scales;
use super::tier::{Tier, at_tier};
use crate::{RayOf, Scalar, TriangleOf};

/// Returns whether a point lies on a triangle, including its edges and corners. The triangle must
/// have nonzero area. Returns false if any coordinate is not finite.
///
/// ```
/// use intertri::Triangle;
/// use intertri::internal::exact::is_on;
/// let wall = Triangle::new([0.0, 0.0, 5.0], [1.0, 0.0, 5.0], [0.0, 1.0, 5.0]);
/// assert!(is_on(&wall, [0.5, 0.5, 5.0]) && is_on(&wall, [0.0, 0.0, 5.0]));
/// assert!(!is_on(&wall, [0.5, 0.500_000_1, 5.0]) && !is_on(&wall, [0.1, 0.1, 5.000_001]));
/// ```
pub fn is_on<S: Scalar>(triangle: &TriangleOf<S>, point: [S; 3]) -> bool {
    // Most points in a triangle's plane are outside the triangle's bounding box. If the CPU treats
    // subnormal numbers as zero, this test rejects fewer points, but it never rejects a point on
    // the triangle.
    let is_beside = |axis: usize| {
        let (x, corners) = (point[axis], &triangle.0);
        corners.iter().all(|c| c[axis] < x) || corners.iter().all(|c| c[axis] > x)
    };
    if (0..3).any(is_beside) {
        return false;
    }
    let dir = [S::ONE, S::ZERO, S::ZERO];
    let ray = RayOf::new(point, dir);
    is_finite(&ray, triangle) && by_integers(&Pair::new(&ray, triangle))
}

#[inline(never)]
fn by_integers(pair: &Pair) -> bool {
    let scales = pair.scales();
    at_tier!(scales.tier(), holds::<C, N, V>(pair, scales))
}

/// Returns whether the point is on the triangle, using integer arithmetic. The point is in the
/// triangle's plane if the volume T is 0. In that case, for each edge, the cross product of the two
/// corners relative to the point is a multiple of the triangle's normal. The point is on the
/// triangle if none of the three factors is negative.
fn holds<const C: usize, const N: usize, const V: usize>(pair: &Pair, scales: Scales) -> bool {
    let numbers = Numbers::<C, N, V>::new(pair, scales);
    let [n1, n2, n3] = &numbers.normals;
    numbers.volume().sign().is_eq()
        && (0..3).any(|axis| {
            let normals = [n1[axis], n2[axis], n3[axis]];
            let own = (n1[axis] + n2[axis] + n3[axis]).sign();
            own.is_ne() && normals.iter().all(|n| n.sign().is_eq() || n.sign() == own)
        })
}
