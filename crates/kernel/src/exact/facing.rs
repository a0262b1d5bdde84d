//! Uses the sign of D to decide exactly from which side a ray approaches a triangle.

use core::cmp::Ordering;

use super::decision::Side;
use super::float;
use super::input::{is_finite, is_plain};
use super::numbers::Pair;
use crate::simd::Vec3;
use crate::{RayOf, Scalar, TriangleOf};

/// Returns whether a ray runs in the direction of a triangle's normal or against it, or `None` if
/// the ray is parallel to the plane or a coordinate is not finite.
///
/// ```
/// use intertri::internal::exact::{Side, facing};
/// use intertri::{Ray, Triangle};
/// let floor = Triangle::new([0.0; 3], [0.0, 0.0, 1.0], [1.0, 0.0, 0.0]);
/// let of = |y| facing(&Ray::new([0.2, 1.0, 0.2], [0.1, y, 0.3]), &floor);
/// assert_eq!([of(-1.0), of(1e-45), of(0.0)], [Some(Side::Enters), Some(Side::Leaves), None]);
/// ```
pub fn facing<S: Scalar>(ray: &RayOf<S>, triangle: &TriangleOf<S>) -> Option<Side> {
    if is_plain(ray, triangle) {
        let corners = triangle.0.map(|corner| Vec3::<f64>::splat(corner.map(Into::into)));
        // `Equal` means undecided here, because only integers can prove that D is exactly 0.
        match float::facing(corners, Vec3::splat(ray.dir.map(Into::into))) {
            Ordering::Greater => return Some(Side::Leaves),
            Ordering::Less => return Some(Side::Enters),
            Ordering::Equal => (),
        }
    }
    by_integers(ray, triangle)
}

#[cold]
#[inline(never)]
fn by_integers<S: Scalar>(ray: &RayOf<S>, triangle: &TriangleOf<S>) -> Option<Side> {
    if !is_finite(ray, triangle) {
        return None;
    }
    match Pair::new(ray, triangle).plane_signs().1 {
        Ordering::Greater => Some(Side::Leaves),
        Ordering::Less => Some(Side::Enters),
        Ordering::Equal => None,
    }
}
