//! Decides exactly whether a triangle has a nonzero area, even if its normal is 0 in f64.

use super::input::is_finite;
use super::numbers::{Numbers, Pair, Scales};
use super::tier::{Tier, at_tier, is_f64};
use crate::{RayOf, Scalar, TriangleOf};

/// Returns whether the area of a finite triangle is nonzero, however small. If it is 0, the
/// triangle is a point or a line segment.
///
/// ```
/// use intertri::Triangle;
/// use intertri::internal::exact::has_area;
/// let along = |x, y| [x, y, 0.0];
/// assert!(!has_area(&Triangle::new(along(0.0, 0.0), along(0.1, 0.1), along(0.3, 0.3))));
/// // The normal of this triangle is 0 in f64.
/// let (a, b) = (along(2.3207207e-9, 2.3207212e-9), along(1.705962, 1.705962));
/// assert!(has_area(&Triangle::new(a, b, along(3.411924, 3.411924))));
/// ```
pub fn has_area<S: Scalar>(triangle: &TriangleOf<S>) -> bool {
    // For a direction along an axis, D is the normal's component along that axis.
    let [c1, ..] = triangle.0;
    (0..3).any(|axis| {
        let mut dir = [S::ZERO; 3];
        dir[axis] = S::ONE;
        let pair = Pair { origin: c1, dir, corners: triangle.0 };
        let scales = pair.scales();
        is_finite(&RayOf::new(c1, dir), triangle)
            && at_tier!(S, scales.tier(), leans::<S, C, N, V>(&pair, scales))
    })
}

/// Returns whether D is nonzero.
fn leans<S: Scalar, const C: usize, const N: usize, const V: usize>(
    pair: &Pair<S>,
    scales: Scales,
) -> bool {
    let [u, v, w] = Numbers::<C, N, V>::new(pair, scales).edges();
    !(u + v + w).sign().is_eq()
}
