//! The truth by a second route: rationals alone, and barycentric weights instead of edge values.

use std::cmp::Ordering;

use intertri::{Ray, Triangle};

use super::{Exact, Place, Truth, is_finite};

/// Three exact numbers.
pub(super) type Vector = [Exact; 3];

/// An f32 vector, exactly; 0 for what is not finite.
pub(super) fn vector(a: [f32; 3]) -> Vector {
    a.map(|x| Exact::try_from(x).unwrap_or_default())
}

/// `a - b`
pub(super) fn difference(a: [f32; 3], b: [f32; 3]) -> Vector {
    let ([ax, ay, az], [bx, by, bz]) = (vector(a), vector(b));
    [ax - bx, ay - by, az - bz]
}

/// `a · b`
pub(super) fn dot(a: &Vector, b: &Vector) -> Exact {
    &a[0] * &b[0] + &a[1] * &b[1] + &a[2] * &b[2]
}

/// `a × b`
pub(super) fn cross(a: &Vector, b: &Vector) -> Vector {
    [&a[1] * &b[2] - &a[2] * &b[1], &a[2] * &b[0] - &a[0] * &b[2], &a[0] * &b[1] - &a[1] * &b[0]]
}

/// The sign of `a · (b × c)`.
pub(super) fn sign_of(a: &Vector, b: &Vector, c: &Vector) -> Ordering {
    sign(&dot(a, &cross(b, c)))
}

fn sign(x: &Exact) -> Ordering {
    x.cmp(&Exact::ZERO)
}

/// What is exactly true of a ray and a triangle, in rationals: slow, and independent of
/// [`truth`](super::truth).
///
/// It solves `origin + t dir = c1 + u (c2 - c1) + v (c3 - c1)` by Cramer's rule, divisions and all, and
/// looks at the signs of the weights `1 - u - v`, `u`, `v`.
pub fn truth(triangle: &Triangle, ray: &Ray) -> Truth {
    if !is_finite(triangle, ray) {
        return Truth::without_t(Place::NotFinite);
    }
    let [c1, c2, c3] = triangle.0;
    let (p, q) = (difference(c2, c1), difference(c3, c1));
    let (d, s) = (vector(ray.dir), difference(ray.origin, c1));
    let n = cross(&p, &q);
    if n.iter().all(Exact::is_zero) {
        return Truth::without_t(Place::Degenerate);
    }

    let det = -dot(&n, &d);
    let height = dot(&n, &s);
    if det.is_zero() {
        return Truth::without_t(if height.is_zero() { Place::Coplanar } else { Place::Parallel });
    }
    let across = cross(&s, &d);
    let u = dot(&q, &across) / &det;
    let v = -dot(&p, &across) / &det;
    let t = height / det;
    let weights = [sign(&(Exact::from(1) - &u - &v)), sign(&u), sign(&v)];
    Truth::classify(weights, sign(&t))
}
