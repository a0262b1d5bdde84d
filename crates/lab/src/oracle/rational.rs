//! The oracle's second implementation. It uses only rationals, and barycentric weights instead of
//! edge values.

use intertri::{RayOf, Scalar, TriangleOf};

use super::exact::{Rational, cross, difference, dot, is_finite, sign, vector};
use super::oracle_answer::{LinePosition, OracleAnswer};

/// Returns the exact answer for a ray and a triangle, computed in rationals. This is slow, but
/// independent of [`super::answer()`].
///
/// Solves `origin + t dir = c1 + u (c2 - c1) + v (c3 - c1)` by Cramer's rule, carrying out the
/// divisions, and uses the signs of the weights `1 - u - v`, `u`, `v`.
pub fn answer<S: Scalar>(triangle: &TriangleOf<S>, ray: &RayOf<S>) -> OracleAnswer {
    if !is_finite(triangle, ray) {
        return OracleAnswer::without_t(LinePosition::NotFinite);
    }
    let [c1, c2, c3] = triangle.0;
    let (p, q) = (difference(c2, c1), difference(c3, c1));
    let (d, s) = (vector(ray.dir), difference(ray.origin, c1));
    let n = cross(&p, &q);
    if n.iter().all(Rational::is_zero) {
        return OracleAnswer::without_t(LinePosition::Degenerate);
    }

    let det = -dot(&n, &d);
    let height = dot(&n, &s);
    if det.is_zero() {
        return OracleAnswer::without_t(if height.is_zero() {
            LinePosition::Coplanar
        } else {
            LinePosition::Parallel
        });
    }
    let across = cross(&s, &d);
    let u = dot(&q, &across) / &det;
    let v = -dot(&p, &across) / &det;
    let t = height / det;
    let weights = [sign(&(Rational::from(1) - &u - &v)), sign(&u), sign(&v)];
    OracleAnswer::classify(weights, sign(&t))
}
