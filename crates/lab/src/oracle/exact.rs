//! Exact arithmetic on f32 or f64 inputs, and the exact `t`.

use std::cmp::Ordering;

use dashu_ratio::Relaxed;
use intertri::{RayOf, Scalar, TriangleOf};

/// An exact rational number.
pub type Rational = Relaxed;

/// A vector with exact components.
pub(super) type Vector = [Rational; 3];

/// Converts a vector to exact numbers. Components that are not finite become 0.
pub(super) fn vector<S: Scalar>(a: [S; 3]) -> Vector {
    a.map(|x| Rational::try_from(Into::<f64>::into(x)).unwrap_or_default())
}

/// `a - b`
pub(super) fn difference<S: Scalar>(a: [S; 3], b: [S; 3]) -> Vector {
    let ([ax, ay, az], [bx, by, bz]) = (vector(a), vector(b));
    [ax - bx, ay - by, az - bz]
}

/// `a · b`
pub(super) fn dot(a: &Vector, b: &Vector) -> Rational {
    &a[0] * &b[0] + &a[1] * &b[1] + &a[2] * &b[2]
}

/// `a × b`
pub(super) fn cross(a: &Vector, b: &Vector) -> Vector {
    [&a[1] * &b[2] - &a[2] * &b[1], &a[2] * &b[0] - &a[0] * &b[2], &a[0] * &b[1] - &a[1] * &b[0]]
}

/// Returns the sign of `a · (b × c)`.
pub(super) fn sign_of(a: &Vector, b: &Vector, c: &Vector) -> Ordering {
    sign(&dot(a, &cross(b, c)))
}

pub(super) fn sign(x: &Rational) -> Ordering {
    x.cmp(&Rational::ZERO)
}

/// Returns whether a ray and a triangle are free of NaN and infinities. The ray's interval may
/// contain them.
pub fn is_finite<S: Scalar>(triangle: &TriangleOf<S>, ray: &RayOf<S>) -> bool {
    let mut numbers = triangle.0.iter().chain([&ray.origin, &ray.dir]).flatten();
    numbers.all(|x| x.is_finite())
}

/// Returns the exact `t` at which the line of a ray meets the plane of a triangle, or `None` if the
/// line is parallel to the plane, the triangle is degenerate, or an input is not finite.
///
/// ```
/// use intertri::{Ray, Triangle};
/// use intertri_lab::oracle::{Rational, exact_t};
/// let triangle = Triangle::new([0.0, 0.0, 1.0], [4.0, 0.0, 1.0], [0.0, 4.0, 1.0]);
/// let t = exact_t(&triangle, &Ray::new([1.0, 1.0, 0.0], [0.0, 0.0, 3.0]));
/// assert_eq!(t, Some(Rational::from(1) / Rational::from(3)));
/// ```
pub fn exact_t<S: Scalar>(triangle: &TriangleOf<S>, ray: &RayOf<S>) -> Option<Rational> {
    if !is_finite(triangle, ray) {
        return None;
    }
    let [a, b, c] = triangle.0.map(|p| difference(p, ray.origin));
    let d = vector(ray.dir);
    let bc = cross(&b, &c);
    let den = dot(&d, &bc) + dot(&d, &cross(&c, &a)) + dot(&d, &cross(&a, &b));
    (!den.is_zero()).then(|| dot(&a, &bc) / den)
}
