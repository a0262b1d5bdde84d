//! Decides exactly whether a triangle has a nonzero area, even if its normal is 0 in f64.

use super::input::is_finite;
use super::numbers::Pair;
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
        let ray = RayOf::new(c1, dir);
        is_finite(&ray, triangle) && Pair::new(&ray, triangle).plane_signs().1.is_ne()
    })
}
