//! The oracle's answer, computed with adaptive predicates.
//!
//! Only signs and one quotient are needed. Each sign is computed by an adaptive predicate (J. R.
//! Shewchuk, "Adaptive precision floating-point arithmetic and fast robust geometric predicates",
//! Discrete & Computational Geometry 18, 1997; here from the `robust` crate), which is exact if its
//! inputs are exact. The difference of two f32 numbers is exact in f64 unless one is about 2^29
//! times the other; in that case, the sign is computed in rationals. Products of f32 numbers stay
//! far from the limits of f64's range, so neither underflow nor overflow affects the predicates. If
//! products of f64 numbers might exceed that range, [`rational`](super::rational) computes the
//! answer.

use std::cmp::Ordering;

use intertri::{RayOf, Scalar, TriangleOf};
use robust::{Coord, Coord3D, orient2d, orient3d};

use super::exact::{self, is_finite};
use super::oracle_answer::{LinePosition, OracleAnswer};
use super::rational;

/// Returns the exact answer for a ray and a triangle, computed with adaptive predicates.
///
/// ```
/// use intertri::{Ray, Triangle};
/// use intertri_lab::oracle::{LinePosition, answer};
/// let triangle = Triangle::new([0.0, 0.0, 5.0], [4.0, 0.0, 5.0], [0.0, 4.0, 5.0]);
/// let at = |x, y| answer(&triangle, &Ray::new([x, y, 0.0], [0.0, 0.0, 1.0]));
/// assert_eq!(at(1.0, 1.0).place, LinePosition::Inside);
/// assert_eq!(at(2.0, 2.0).place, LinePosition::Edge(0));
/// assert_eq!(at(4.0, 0.0).place, LinePosition::Vertex(1));
/// assert_eq!(at(2.0_f32.next_up(), 2.0).place, LinePosition::Outside);
/// ```
pub fn answer<S: Scalar>(triangle: &TriangleOf<S>, ray: &RayOf<S>) -> OracleAnswer {
    if !is_finite(triangle, ray) {
        return OracleAnswer::without_t(LinePosition::NotFinite);
    }
    if !is_tame(triangle, ray) {
        return rational::answer(triangle, ray);
    }
    let [c1, c2, c3] = triangle.0;

    // Is the triangle degenerate? It is if its projections onto all three coordinate planes are.
    let flat = |x: usize, y: usize| {
        let point = |p: [S; 3]| Coord::<f64> { x: p[x].into(), y: p[y].into() };
        orient2d(point(c1), point(c2), point(c3)) == 0.0
    };
    if flat(0, 1) && flat(1, 2) && flat(2, 0) {
        return OracleAnswer::without_t(LinePosition::Degenerate);
    }

    // Does the line meet the plane at one point?
    let rise = sign(orient3d(point(c1), point(c2), point(c3), point(ray.origin)));
    let slope = slope(triangle, ray.dir);
    if slope.is_eq() {
        return OracleAnswer::without_t(if rise.is_eq() {
            LinePosition::Coplanar
        } else {
            LinePosition::Parallel
        });
    }

    // On which side of each edge does the line pass?
    let edges = [(c2, c3), (c3, c1), (c1, c2)].map(|(p, q)| edge(p, q, ray));
    OracleAnswer::classify(edges, if slope.is_lt() { rise.reverse() } else { rise })
}

/// Returns whether products of three coordinate differences, and the terms into which the
/// predicates split them, stay within f64's range. For f32 inputs, they always do.
fn is_tame<S: Scalar>(triangle: &TriangleOf<S>, ray: &RayOf<S>) -> bool {
    let mut numbers = triangle.0.iter().chain([&ray.origin, &ray.dir]).flatten();
    numbers.all(|&x| {
        let size = Into::<f64>::into(x).abs();
        size == 0.0 || (1e-60..1e60).contains(&size)
    })
}

/// Returns the sign of `n · d`, with `n = (c2 - c1) × (c3 - c1)`.
fn slope<S: Scalar>(triangle: &TriangleOf<S>, d: [S; 3]) -> Ordering {
    let [c1, c2, c3] = triangle.0;
    match (exact_difference(c2, c1), exact_difference(c3, c1)) {
        (Some(p), Some(q)) => sign(orient3d(point(d), p, q, ZERO)),
        _ => exact::sign_of(
            &exact::vector(d),
            &exact::difference(c2, c1),
            &exact::difference(c3, c1),
        ),
    }
}

/// Returns the sign of `d · (P × Q)`, where `P` and `Q` are the ends of a side relative to the
/// origin.
fn edge<S: Scalar>(p: [S; 3], q: [S; 3], ray: &RayOf<S>) -> Ordering {
    match (exact_difference(p, ray.origin), exact_difference(q, ray.origin)) {
        (Some(p), Some(q)) => sign(orient3d(point(ray.dir), p, q, ZERO)),
        _ => exact::sign_of(
            &exact::vector(ray.dir),
            &exact::difference(p, ray.origin),
            &exact::difference(q, ray.origin),
        ),
    }
}

const ZERO: Coord3D<f64> = Coord3D { x: 0.0, y: 0.0, z: 0.0 };

fn point64([x, y, z]: [f64; 3]) -> Coord3D<f64> {
    Coord3D { x, y, z }
}

fn point<S: Scalar>(p: [S; 3]) -> Coord3D<f64> {
    point64(p.map(Into::into))
}

/// Returns `a - b` if it is exact in f64, that is, if the tail of the difference (D. E. Knuth's
/// `TwoDiff`) is 0.
pub(super) fn exact_difference<S: Scalar>(a: [S; 3], b: [S; 3]) -> Option<Coord3D<f64>> {
    let mut difference = [0.0; 3];
    for k in 0..3 {
        let (a, b): (f64, f64) = (a[k].into(), b[k].into());
        let x = a - b;
        let b_seen = a - x;
        let a_seen = x + b_seen;
        if (a - a_seen) + (b_seen - b) != 0.0 {
            return None;
        }
        difference[k] = x;
    }
    Some(point64(difference))
}

fn sign(x: f64) -> Ordering {
    // Both 0 and -0 compare equal to 0, and the predicates never return NaN for finite inputs.
    x.partial_cmp(&0.0).unwrap_or(Ordering::Equal)
}
