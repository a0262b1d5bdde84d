//! What is true of a ray and a triangle, in rationals: by Cramer's rule for `c1 + u (c2 - c1) + v (c3 - c1)`
//! where the kernel has three volumes, and by a direction that is moved in fact where it has a tie rule.

use dashu_ratio::Relaxed as Rational;
use intertri::{Ray, Triangle};

type Vector = [Rational; 3];

/// Where the line of a ray meets the plane of a triangle.
pub(crate) struct Truth {
    pub(crate) t: Rational,
    pub(crate) u: Rational,
    pub(crate) v: Rational,
    /// Whether the ray runs with the normal.
    pub(crate) leaves: bool,
}

fn vector(v: [f32; 3]) -> Vector {
    v.map(|x| Rational::try_from(x).unwrap())
}

fn minus(a: &Vector, b: &Vector) -> Vector {
    [&a[0] - &b[0], &a[1] - &b[1], &a[2] - &b[2]]
}

fn dot(a: &Vector, b: &Vector) -> Rational {
    &a[0] * &b[0] + &a[1] * &b[1] + &a[2] * &b[2]
}

fn cross(a: &Vector, b: &Vector) -> Vector {
    [&a[1] * &b[2] - &a[2] * &b[1], &a[2] * &b[0] - &a[0] * &b[2], &a[0] * &b[1] - &a[1] * &b[0]]
}

fn is_finite(ray: &Ray, triangle: &Triangle) -> bool {
    triangle.0.iter().chain([&ray.origin, &ray.dir]).flatten().all(|x| x.is_finite())
}

/// Where a line with that direction meets the plane.
fn along(ray: &Ray, dir: &Vector, triangle: &Triangle) -> Option<Truth> {
    let [c1, c2, c3] = triangle.0.map(vector);
    let (p, q, s) = (minus(&c2, &c1), minus(&c3, &c1), minus(&vector(ray.origin), &c1));
    let n = cross(&p, &q);
    let det = dot(&n, dir);
    if det.is_zero() {
        return None;
    }
    let across = cross(dir, &s);
    let u = dot(&q, &across) / &det;
    let v = -dot(&p, &across) / &det;
    let t = -dot(&n, &s) / &det;
    Some(Truth { t, u, v, leaves: det > Rational::ZERO })
}

/// Where the line meets the plane in one point.
pub(crate) fn truth(ray: &Ray, triangle: &Triangle) -> Option<Truth> {
    if !is_finite(ray, triangle) {
        return None;
    }
    along(ray, &vector(ray.dir), triangle)
}

impl Truth {
    /// Whether the point is in the closed triangle and before the origin.
    pub(crate) fn is_closed_hit(&self) -> bool {
        let zero = Rational::ZERO;
        self.t > zero && self.u >= zero && self.v >= zero && &self.u + &self.v <= Rational::ONE
    }

    /// Whether t is in the interval of a ray.
    pub(crate) fn is_within(&self, ray: &Ray) -> bool {
        // Both ends are compared as they are given, those below 0, too: t is not.
        let near = Rational::try_from(ray.t_min).map(|near| near <= self.t);
        let far = Rational::try_from(ray.t_max).map(|far| self.t < far);
        !ray.t_min.is_nan()
            && !ray.t_max.is_nan()
            && ray.t_min < ray.t_max
            && near.unwrap_or(ray.t_min < 0.0)
            && far.unwrap_or(ray.t_max > 0.0)
    }
}

/// Whether a ray crosses a triangle by the once rule: leaves it, enters it or neither. The direction is
/// moved by (ε, ε², ε³), with an ε below what any two terms can differ by.
pub(crate) fn once(ray: &Ray, triangle: &Triangle, truth: Option<&Truth>) -> Option<bool> {
    if !is_finite(ray, triangle) || ray.dir == [0.0; 3] {
        return None;
    }
    // What is strictly inside or outside stays so.
    if let Some(truth) = truth {
        let zero = Rational::ZERO;
        let first = &Rational::ONE - &truth.u - &truth.v;
        let weights = [&first, &truth.u, &truth.v];
        if weights.iter().any(|weight| **weight < zero) {
            return None;
        }
        if weights.iter().all(|weight| **weight > zero) {
            return (truth.t > zero).then_some(truth.leaves);
        }
    }
    let mut dir = vector(ray.dir);
    let step = Rational::try_from(2.0_f64.powi(-1000)).unwrap();
    let mut power = step.clone();
    for x in &mut dir {
        *x += &power;
        power *= &step;
    }
    let moved = along(ray, &dir, triangle)?;
    let zero = Rational::ZERO;
    let outside = moved.u < zero || moved.v < zero || &moved.u + &moved.v > Rational::ONE;
    if outside || moved.t <= zero {
        return None;
    }
    // Nothing but a point of the plane itself can lie on an edge still.
    assert!(moved.u > zero && moved.v > zero && &moved.u + &moved.v < Rational::ONE);
    Some(moved.leaves)
}

/// Whether an f64 is a rational rounded to nearest, ties to even.
pub(crate) fn is_rounded(x: f64, exact: &Rational) -> bool {
    if !x.is_finite() {
        return false;
    }
    if exact.is_zero() {
        return x == 0.0;
    }
    let half = |y: f64| (rational(x) + rational(y)) / Rational::from(2);
    let (below, above) = (half(x.next_down()), half(x.next_up()));
    let even = x.to_bits() & 1 == 0;
    if even { below <= *exact && *exact <= above } else { below < *exact && *exact < above }
}

fn rational(x: f64) -> Rational {
    Rational::try_from(x).unwrap()
}
