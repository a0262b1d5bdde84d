//! The truth: where the line of a ray meets a triangle, for f32 inputs, without any rounding.
//!
//! With `A, B, C` the corners seen from the origin and `d` the direction,
//!
//! ```text
//!   U = d · (B × C)                    C                   the line passes every side on the same
//!   V = d · (C × A)                   /  \                 hand: inside. A value of 0: on that
//!   W = d · (A × B)              V=0 /  +  \  U=0          side. Two of them: at the corner
//!   t = A · (B × C) / (U + V + W)   A ------ B             between.
//!                                      W=0
//! ```
//!
//! Only signs and one quotient are needed. Each sign is asked of an adaptive predicate (J. R.
//! Shewchuk, "Adaptive precision floating-point arithmetic and fast robust geometric predicates",
//! Discrete & Computational Geometry 18, 1997; here the crate `robust`), which is exact as long as its
//! inputs are. A difference of two f32 is exact in f64 unless they are some 2^29 apart; there the sign
//! is computed in rationals instead. No product of f32 comes near the ends of f64's range, so neither
//! underflow nor overflow spoils the predicates.
//!
//! [`rational`] finds the same by another formula and rationals alone; the two are tested against each
//! other on every family.

pub mod rational;

use std::cmp::Ordering;

use dashu_ratio::Relaxed;
use intertri::{Ray, Triangle};
use robust::{Coord, Coord3D, orient2d, orient3d};

/// An exact number.
pub type Exact = Relaxed;

/// Where the *line* of a ray meets a triangle. Of several that hold, the first in this list.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Place {
    /// Not asked: an input is NaN or infinite.
    NotFinite,
    /// Nowhere: the triangle has no area.
    Degenerate,
    /// The line lies in the plane of the triangle, or the direction is 0 and the origin lies in it.
    Coplanar,
    /// The line is parallel to the plane, or the direction is 0.
    Parallel,
    /// Outside of the triangle.
    Outside,
    /// At the corner of this number (0, 1, 2).
    Vertex(u8),
    /// On the side across from the corner of this number, between its ends.
    Edge(u8),
    /// Inside of all three sides.
    Inside,
}

/// What is exactly true of a ray and a triangle; the interval of the ray does not matter.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Truth {
    /// Where the line meets the triangle.
    pub place: Place,
    /// `t` compared with 0: `Less` behind the origin, `Equal` at it, `Greater` in front. `Equal`, too,
    /// where the place says that there is no `t`.
    pub t: Ordering,
}

impl Truth {
    /// Whether the open half-line `t > 0` meets the triangle, whose sides and corners belong to it.
    ///
    /// A ray in the triangle's plane does not; this is what the document's parallel test means.
    pub fn is_hit(self) -> bool {
        self.t == Ordering::Greater
            && matches!(self.place, Place::Inside | Place::Edge(_) | Place::Vertex(_))
    }

    /// The place of three edge values by their signs, `U` first; the plane is met in one point.
    fn classify(signs: [Ordering; 3], t: Ordering) -> Self {
        let count = |sign| signs.iter().filter(|&&s| s == sign).count();
        let position = |zero: bool| signs.iter().position(|s| (s.is_eq()) == zero);
        let place = if count(Ordering::Less) > 0 && count(Ordering::Greater) > 0 {
            Place::Outside
        } else {
            match count(Ordering::Equal) {
                0 => Place::Inside,
                // One value is 0: on the side of that name.
                1 => Place::Edge(position(true).unwrap_or(0) as u8),
                // One value is not: at the corner of that name.
                _ => Place::Vertex(position(false).unwrap_or(0) as u8),
            }
        };
        Self { place, t }
    }

    /// A place without a `t`.
    fn without_t(place: Place) -> Self {
        Self { place, t: Ordering::Equal }
    }
}

/// What is exactly true of a ray and a triangle, by adaptive predicates.
///
/// ```
/// use intertri::{Ray, Triangle};
/// use intertri_lab::truth::{Place, truth};
/// let triangle = Triangle::new([0.0, 0.0, 5.0], [4.0, 0.0, 5.0], [0.0, 4.0, 5.0]);
/// let at = |x, y| truth(&triangle, &Ray::new([x, y, 0.0], [0.0, 0.0, 1.0]));
/// assert_eq!(at(1.0, 1.0).place, Place::Inside);
/// assert_eq!(at(2.0, 2.0).place, Place::Edge(0));
/// assert_eq!(at(4.0, 0.0).place, Place::Vertex(1));
/// assert_eq!(at(2.0_f32.next_up(), 2.0).place, Place::Outside);
/// ```
pub fn truth(triangle: &Triangle, ray: &Ray) -> Truth {
    if !is_finite(triangle, ray) {
        return Truth::without_t(Place::NotFinite);
    }
    let [c1, c2, c3] = triangle.0;

    // Is there an area? Not if it vanishes in all three coordinate planes.
    let flat = |x: usize, y: usize| {
        let point = |p: [f32; 3]| Coord { x: p[x], y: p[y] };
        orient2d(point(c1), point(c2), point(c3)) == 0.0
    };
    if flat(0, 1) && flat(1, 2) && flat(2, 0) {
        return Truth::without_t(Place::Degenerate);
    }

    // Is there one point in which the line meets the plane?
    let rise = sign(orient3d(point(c1), point(c2), point(c3), point(ray.origin)));
    let slope = slope(triangle, ray.dir);
    if slope.is_eq() {
        return Truth::without_t(if rise.is_eq() { Place::Coplanar } else { Place::Parallel });
    }

    // On which hand does the line pass the sides?
    let edges = [(c2, c3), (c3, c1), (c1, c2)].map(|(p, q)| edge(p, q, ray));
    Truth::classify(edges, if slope.is_lt() { rise.reverse() } else { rise })
}

/// The exact `t` at which the line of a ray meets the plane of a triangle; nothing where the line is
/// parallel, the triangle has no area, or an input is not finite.
///
/// ```
/// use intertri::{Ray, Triangle};
/// use intertri_lab::truth::{Exact, exact_t};
/// let triangle = Triangle::new([0.0, 0.0, 1.0], [4.0, 0.0, 1.0], [0.0, 4.0, 1.0]);
/// let t = exact_t(&triangle, &Ray::new([1.0, 1.0, 0.0], [0.0, 0.0, 3.0]));
/// assert_eq!(t, Some(Exact::from(1) / Exact::from(3)));
/// ```
pub fn exact_t(triangle: &Triangle, ray: &Ray) -> Option<Exact> {
    if !is_finite(triangle, ray) {
        return None;
    }
    let [a, b, c] = triangle.0.map(|p| rational::difference(p, ray.origin));
    let d = rational::vector(ray.dir);
    let cross = rational::cross(&b, &c);
    let den = rational::dot(&d, &cross)
        + rational::dot(&d, &rational::cross(&c, &a))
        + rational::dot(&d, &rational::cross(&a, &b));
    (!den.is_zero()).then(|| rational::dot(&a, &cross) / den)
}

/// How far a computed `t` is from the exact one, relative to the exact one; `|t|` where that is 0.
/// Infinite for an infinite `t`, NaN for NaN.
pub fn t_error(t: f64, exact: &Exact) -> f64 {
    let Ok(t) = Exact::try_from(t) else { return t.abs() };
    let off = (t - exact).to_f64().value().abs();
    let size = exact.to_f64().value().abs();
    if size == 0.0 { off } else { off / size }
}

/// How far a computed `t` is from the exact one, in units of the last place of the f64 next to it.
/// Infinite for an infinite `t`, NaN for NaN. No `t` of f32 inputs leaves f64's normal range.
///
/// ```
/// use intertri_lab::truth::{Exact, t_error_ulps};
/// let third = Exact::from(1) / Exact::from(3);
/// assert!(t_error_ulps(1.0 / 3.0, &third) < 0.5);
/// assert!((t_error_ulps((1.0_f64 / 3.0).next_up(), &third) - 1.0).abs() < 0.5);
/// ```
pub fn t_error_ulps(t: f64, exact: &Exact) -> f64 {
    let near = exact.to_f64().value().abs();
    in_steps(t, exact, near.next_up() - near)
}

/// The same in units of the last place of the f32 next to the exact `t`; infinite where that f32 is.
pub fn t_error_ulps_f32(t: f32, exact: &Exact) -> f64 {
    let near = (exact.to_f64().value() as f32).abs();
    if near.is_infinite() {
        return if t.is_nan() { f64::NAN } else { f64::INFINITY };
    }
    // The largest f32 has its step downward.
    let step = if near == f32::MAX { near - near.next_down() } else { near.next_up() - near };
    in_steps(t.into(), exact, step.into())
}

fn in_steps(t: f64, exact: &Exact, step: f64) -> f64 {
    let Ok(t) = Exact::try_from(t) else { return t.abs() };
    (t - exact).to_f64().value().abs() / step
}

/// Whether a ray and a triangle are free of NaN and infinities; the interval may have them.
pub fn is_finite(triangle: &Triangle, ray: &Ray) -> bool {
    let mut numbers = triangle.0.iter().chain([&ray.origin, &ray.dir]).flatten();
    numbers.all(|x| x.is_finite())
}

/// The sign of `n · d`, `n = (c2 - c1) × (c3 - c1)`.
fn slope(triangle: &Triangle, d: [f32; 3]) -> Ordering {
    let [c1, c2, c3] = triangle.0;
    match (exact_difference(c2, c1), exact_difference(c3, c1)) {
        (Some(p), Some(q)) => sign(orient3d(point(d), p, q, ZERO)),
        _ => rational::sign_of(
            &rational::vector(d),
            &rational::difference(c2, c1),
            &rational::difference(c3, c1),
        ),
    }
}

/// The sign of `d · (P × Q)`, `P` and `Q` the ends of a side seen from the origin.
fn edge(p: [f32; 3], q: [f32; 3], ray: &Ray) -> Ordering {
    match (exact_difference(p, ray.origin), exact_difference(q, ray.origin)) {
        (Some(p), Some(q)) => sign(orient3d(point(ray.dir), p, q, ZERO)),
        _ => rational::sign_of(
            &rational::vector(ray.dir),
            &rational::difference(p, ray.origin),
            &rational::difference(q, ray.origin),
        ),
    }
}

const ZERO: Coord3D<f64> = Coord3D { x: 0.0, y: 0.0, z: 0.0 };

fn point64([x, y, z]: [f64; 3]) -> Coord3D<f64> {
    Coord3D { x, y, z }
}

fn point(p: [f32; 3]) -> Coord3D<f64> {
    point64(p.map(f64::from))
}

/// `a - b` where f64 holds it exactly: where the tail of the difference (D. E. Knuth's `TwoDiff`) is 0.
fn exact_difference(a: [f32; 3], b: [f32; 3]) -> Option<Coord3D<f64>> {
    let mut difference = [0.0; 3];
    for k in 0..3 {
        let (a, b) = (f64::from(a[k]), f64::from(b[k]));
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
    // Both zeros are equal to 0; the predicates of finite numbers are never NaN.
    x.partial_cmp(&0.0).unwrap_or(Ordering::Equal)
}

#[cfg(test)]
mod tests;
