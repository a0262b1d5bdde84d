//! What is true of a ray and a triangle, in integers of any size: by Cramer's rule for
//! `c1 + u (c2 - c1) + v (c3 - c1)` where the kernel has three volumes, and by a direction that is moved in fact
//! where it has a tie rule.

use std::cmp::Ordering;

use dashu_int::IBig;
use dashu_int::ops::BitTest;
use intertri::{RayOf, Scalar, TriangleOf};

type Vector = [IBig; 3];

/// Where the line of a ray meets the plane of a triangle.
pub struct Truth {
    t: Ratio,
    u: Ratio,
    v: Ratio,
    /// Whether the ray runs with the normal.
    leaves: bool,
}

/// `num / den * 2^exponent`, with a positive denominator.
struct Ratio {
    num: IBig,
    den: IBig,
    exponent: i64,
}

/// m and e of a finite number `m * 2^e`.
fn parts(x: f64) -> (i64, i64) {
    let (bits, size) = (x.to_bits(), x.abs().to_bits());
    let (field, fraction) = ((size >> 52) as i64, (size & ((1 << 52) - 1)) as i64);
    let m = if field == 0 { fraction } else { fraction | 1 << 52 };
    (if bits >> 63 == 0 { m } else { -m }, field.max(1) - 1075)
}

/// Vectors as multiples of one power of two.
fn integers<S: Scalar>(vectors: &[[S; 3]]) -> (Vec<Vector>, i64) {
    let numbers = || vectors.iter().flatten().map(|&x| parts(x.into())).filter(|&(m, _)| m != 0);
    let low = numbers().map(|(m, e)| e + i64::from(m.trailing_zeros())).min().unwrap_or(0);
    let integer = |x: S| {
        let (m, e) = parts(x.into());
        shifted(IBig::from(m), e - low)
    };
    (vectors.iter().map(|v| v.map(integer)).collect(), low)
}

/// `x * 2^by`, which is an integer.
fn shifted(x: IBig, by: i64) -> IBig {
    if by < 0 { x >> by.unsigned_abs() as usize } else { x << by as usize }
}

/// Whether a point lies on a triangle that has an area; of one without, never.
pub fn is_on<S: Scalar>(point: [S; 3], triangle: &TriangleOf<S>) -> bool {
    let [c1, c2, c3] = triangle.0;
    let (points, _) = integers(&[point, c1, c2, c3]);
    let [p, c1, c2, c3] = &points[..] else { unreachable!() };
    let n = cross(&minus(c2, c1), &minus(c3, c1));
    let side = |a, b| dot(&cross(&minus(b, a), &minus(p, a)), &n) >= IBig::ZERO;
    n.iter().any(|x| *x != IBig::ZERO)
        && dot(&n, &minus(p, c1)) == IBig::ZERO
        && side(c1, c2)
        && side(c2, c3)
        && side(c3, c1)
}

fn minus(a: &Vector, b: &Vector) -> Vector {
    [&a[0] - &b[0], &a[1] - &b[1], &a[2] - &b[2]]
}

fn dot(a: &Vector, b: &Vector) -> IBig {
    &a[0] * &b[0] + &a[1] * &b[1] + &a[2] * &b[2]
}

fn cross(a: &Vector, b: &Vector) -> Vector {
    [&a[1] * &b[2] - &a[2] * &b[1], &a[2] * &b[0] - &a[0] * &b[2], &a[0] * &b[1] - &a[1] * &b[0]]
}

fn is_finite<S: Scalar>(ray: &RayOf<S>, triangle: &TriangleOf<S>) -> bool {
    let finite = |&x: &S| Into::<f64>::into(x).is_finite();
    triangle.0.iter().chain([&ray.origin, &ray.dir]).flatten().all(finite)
}

/// Where a line with a direction in integers meets the plane.
fn along<S: Scalar>(
    ray: &RayOf<S>,
    (dir, dir_low): (&Vector, i64),
    triangle: &TriangleOf<S>,
) -> Option<Truth> {
    let [c1, c2, c3] = triangle.0;
    let (points, low) = integers(&[ray.origin, c1, c2, c3]);
    let [o, c1, c2, c3] = &points[..] else { unreachable!() };
    let (p, q, s) = (minus(c2, c1), minus(c3, c1), minus(o, c1));
    let n = cross(&p, &q);
    let det = dot(&n, dir);
    if det == IBig::ZERO {
        return None;
    }
    let (across, leaves) = (cross(dir, &s), det > IBig::ZERO);
    let over = |num: IBig, exponent| Ratio {
        num: if leaves { num } else { -num },
        den: if leaves { det.clone() } else { -&det },
        exponent,
    };
    let (u, v) = (over(dot(&q, &across), 0), over(-dot(&p, &across), 0));
    Some(Truth { t: over(-dot(&n, &s), low - dir_low), u, v, leaves })
}

/// Where the line meets the plane in one point.
pub fn truth<S: Scalar>(ray: &RayOf<S>, triangle: &TriangleOf<S>) -> Option<Truth> {
    if !is_finite(ray, triangle) {
        return None;
    }
    let (dir, low) = integers(&[ray.dir]);
    along(ray, (&dir[0], low), triangle)
}

impl Truth {
    /// The weights times the denominator, which is positive.
    fn weights(&self) -> [IBig; 3] {
        let (u, v) = (&self.u.num, &self.v.num);
        [&self.u.den - u - v, u.clone(), v.clone()]
    }

    /// Whether the point is in the closed triangle and before the origin.
    pub fn is_closed_hit(&self) -> bool {
        self.t.num > IBig::ZERO && self.weights().iter().all(|weight| *weight >= IBig::ZERO)
    }

    /// Whether t is in the interval of a ray.
    pub fn is_within<S: Scalar>(&self, ray: &RayOf<S>) -> bool {
        // Both ends are compared as they are given, those below 0, too: t is not.
        let (near, far): (f64, f64) = (ray.t_min.into(), ray.t_max.into());
        let from = !near.is_finite() || self.t.cmp(near).is_ge();
        let to = !far.is_finite() || self.t.cmp(far).is_lt();
        near < far && from && to
    }

    /// Whether one t is below another's, of the same ray.
    pub fn order(&self, other: &Self) -> Ordering {
        let (a, b) = (&self.t, &other.t);
        let low = a.exponent.min(b.exponent);
        let over = |a: &Ratio, b: &Ratio| shifted(&a.num * &b.den, a.exponent - low);
        over(a, b).cmp(&over(b, a))
    }

    /// Whether three f64 are t, u and v, each rounded to nearest, ties to even.
    pub fn are_rounded(&self, [t, u, v]: [f64; 3]) -> bool {
        self.t.is_rounded(t) && self.u.is_rounded(u) && self.v.is_rounded(v)
    }

    /// An f32 near t.
    pub fn t_f32(&self) -> f32 {
        self.t_f64() as f32
    }

    /// An f64 near t.
    pub fn t_f64(&self) -> f64 {
        // Twice the digits that are asked for, then a power of two that may be beyond any f32.
        let up = self.t.den.bit_len() as i64 - self.t.num.bit_len() as i64 + 60;
        let q = shifted(self.t.num.clone(), up.max(0)) / shifted(self.t.den.clone(), (-up).max(0));
        let (q, e) = (i64::try_from(q).unwrap() as f64, (self.t.exponent - up) as i32);
        q * 2.0_f64.powi(e / 2) * 2.0_f64.powi(e - e / 2)
    }
}

impl Ratio {
    /// Compared with a finite number.
    fn cmp(&self, x: f64) -> Ordering {
        let (m, e) = parts(x);
        self.cmp_parts(m, e)
    }

    /// Compared with `m * 2^e`.
    fn cmp_parts(&self, m: i64, e: i64) -> Ordering {
        let low = self.exponent.min(e);
        let (left, right) = (shifted(self.num.clone(), self.exponent - low), &self.den * m);
        left.cmp(&shifted(right, e - low))
    }

    /// Whether a number is the nearest, the even one of two.
    fn is_rounded(&self, x: f64) -> bool {
        let (m, e) = parts(x);
        // Up to half the least, and from half a unit above the largest on.
        if m == 0 {
            return self.cmp_parts(1, -1075).is_le() && self.cmp_parts(-1, -1075).is_ge();
        }
        if x.is_infinite() {
            let (beyond, sign) = ((1 << 54) - 1, if x > 0.0 { 1 } else { -1 });
            let order = self.cmp_parts(sign * beyond, 1024 - 54);
            return if x > 0.0 { order.is_ge() } else { order.is_le() };
        }
        if x.is_nan() {
            return false;
        }
        // Half-way to the next ones, toward 0 and away from it; a power of two is nearer to the first.
        let (sign, size) = (m.signum(), m.abs());
        let inner = if size == 1 << 52 && e > -1074 { 4 * size - 1 } else { 4 * size - 2 };
        let inner = self.cmp_parts(sign * inner, e - 2);
        let outer = self.cmp_parts(sign * (4 * size + 2), e - 2);
        let (inner, outer) =
            if sign > 0 { (inner, outer) } else { (inner.reverse(), outer.reverse()) };
        let even = m & 1 == 0;
        if even { inner.is_ge() && outer.is_le() } else { inner.is_gt() && outer.is_lt() }
    }
}

/// A step from one power of ε to the next, in bits: more than any N is longer than any X.
const STEP: usize = 600;
/// The same of f64.
const STEP_64: usize = 6500;

/// Whether a ray crosses a triangle by the once rule: leaves it, enters it or neither. The direction is
/// moved by (ε, ε², ε³), with an ε below what any two terms can differ by.
pub fn once<S: Scalar>(
    ray: &RayOf<S>,
    triangle: &TriangleOf<S>,
    truth: Option<&Truth>,
) -> Option<bool> {
    if !is_finite(ray, triangle) || ray.dir == [S::ZERO; 3] {
        return None;
    }
    // What is strictly inside or outside stays so.
    if let Some(truth) = truth {
        let weights = truth.weights();
        if weights.iter().any(|weight| *weight < IBig::ZERO) {
            return None;
        }
        if weights.iter().all(|weight| *weight > IBig::ZERO) {
            return (truth.t.num > IBig::ZERO).then_some(truth.leaves);
        }
    }
    let step = if size_of::<S>() > size_of::<f32>() { STEP_64 } else { STEP };
    let (mut dir, low) = integers(&[ray.dir]);
    for (power, x) in (0..3).rev().zip(&mut dir[0]) {
        *x = (x.clone() << (3 * step)) + (IBig::ONE << (power * step));
    }
    let moved = along(ray, (&dir[0], low), triangle)?;
    let weights = moved.weights();
    if weights.iter().any(|weight| *weight < IBig::ZERO) || moved.t.num <= IBig::ZERO {
        return None;
    }
    // Nothing is on an edge still.
    assert!(weights.iter().all(|weight| *weight > IBig::ZERO));
    Some(moved.leaves)
}
