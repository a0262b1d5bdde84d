//! Computes the exact result for a ray and a triangle with arbitrary-precision integers. The method
//! differs from the kernel's: the kernel computes three volumes, whereas this module applies
//! Cramer's rule to `c1 + u (c2 - c1) + v (c3 - c1)`; and the kernel applies a tie rule, whereas
//! this module actually moves the direction.

use std::cmp::Ordering;

use dashu_int::IBig;
use dashu_int::ops::BitTest;
use intertri::{RayOf, Scalar, TriangleOf};

type Vector<I> = [I; 3];

/// The exact intersection of a ray's line with a triangle's plane.
pub struct Truth {
    t: Ratio,
    u: Ratio,
    v: Ratio,
    /// Whether the ray crosses the plane in the direction of the triangle's normal.
    leaves: bool,
}

/// `num / den * 2^exponent`, with a positive denominator.
struct Ratio {
    num: IBig,
    den: IBig,
    exponent: i64,
}

/// Splits a finite number `m * 2^e` into the integers m and e.
fn parts(x: f64) -> (i64, i64) {
    let (bits, size) = (x.to_bits(), x.abs().to_bits());
    let (field, fraction) = ((size >> 52) as i64, (size & ((1 << 52) - 1)) as i64);
    let m = if field == 0 { fraction } else { fraction | 1 << 52 };
    (if bits >> 63 == 0 { m } else { -m }, field.max(1) - 1075)
}

/// Converts the components of vectors to integer multiples of a common power of two. Also returns
/// the exponent of this power.
fn integers<S: Scalar>(vectors: &[[S; 3]]) -> (Vec<Vector<IBig>>, i64) {
    let low = Scale::of(vectors).low;
    (vectors.iter().map(|&v| vector(v, low)).collect(), low)
}

/// Converts the components of a vector to integer multiples of `2^low`.
fn vector<S: Scalar, I: Integer>(v: [S; 3], low: i64) -> Vector<I> {
    v.map(|x| {
        let (m, e) = parts(x.into());
        if m == 0 { I::of(0, 0) } else { I::of(m, e - low) }
    })
}

/// The range of the components of several vectors: all are multiples of `2^low` and below
/// `2^(low + bits)` in magnitude.
struct Scale {
    low: i64,
    bits: i64,
}

impl Scale {
    fn of<S: Scalar>(vectors: &[[S; 3]]) -> Self {
        let (mut low, mut high) = (i64::MAX, i64::MIN);
        for &x in vectors.iter().flatten() {
            let (m, e) = parts(x.into());
            if m != 0 {
                low = low.min(e + i64::from(m.trailing_zeros()));
                high = high.max(e + 64 - i64::from(m.unsigned_abs().leading_zeros()));
            }
        }
        if low > high { Self { low: 0, bits: 0 } } else { Self { low, bits: high - low } }
    }
}

/// Returns `x * 2^by`, which must be an integer.
fn shifted(x: IBig, by: i64) -> IBig {
    if by < 0 { x >> by.unsigned_abs() as usize } else { x << by as usize }
}

/// Returns whether a point is on a triangle. A triangle with zero area contains no points.
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

fn minus<I: Integer>(a: &Vector<I>, b: &Vector<I>) -> Vector<I> {
    [a[0].minus(&b[0]), a[1].minus(&b[1]), a[2].minus(&b[2])]
}

fn dot<I: Integer>(a: &Vector<I>, b: &Vector<I>) -> I {
    let [x, y, z] = [a[0].times(&b[0]), a[1].times(&b[1]), a[2].times(&b[2])];
    x.plus(&y).plus(&z)
}

fn cross<I: Integer>(a: &Vector<I>, b: &Vector<I>) -> Vector<I> {
    let minor = |i: usize, j: usize| a[i].times(&b[j]).minus(&a[j].times(&b[i]));
    [minor(1, 2), minor(2, 0), minor(0, 1)]
}

fn is_finite<S: Scalar>(ray: &RayOf<S>, triangle: &TriangleOf<S>) -> bool {
    let finite = |&x: &S| Into::<f64>::into(x).is_finite();
    triangle.0.iter().chain([&ray.origin, &ray.dir]).flatten().all(finite)
}

/// The edges of a triangle, a ray's origin relative to the first corner, and the triangle's normal,
/// as integers.
struct IntegerPair<I> {
    p: Vector<I>,
    q: Vector<I>,
    s: Vector<I>,
    n: Vector<I>,
}

/// The solution by Cramer's rule: t, u and v, each multiplied by the determinant, and the
/// determinant itself.
struct Cramer<I> {
    t: I,
    u: I,
    v: I,
    det: I,
}

impl<I: Integer> IntegerPair<I> {
    fn new<S: Scalar>(origin: [S; 3], triangle: &TriangleOf<S>, low: i64) -> Self {
        let [c1, c2, c3] = triangle.0.map(|c| vector::<S, I>(c, low));
        let (p, q) = (minus(&c2, &c1), minus(&c3, &c1));
        let (s, n) = (minus(&vector(origin, low), &c1), cross(&p, &q));
        Self { p, q, s, n }
    }

    /// Solves for t, u and v along a given direction.
    fn along(&self, dir: &Vector<I>) -> Cramer<I> {
        let (Self { p, q, s, n }, zero) = (self, I::of(0, 0));
        let across = cross(dir, s);
        let (t, v) = (zero.minus(&dot(n, s)), zero.minus(&dot(p, &across)));
        Cramer { t, u: dot(q, &across), v, det: dot(n, dir) }
    }
}

impl<I: Integer> Cramer<I> {
    /// Returns the intersection, or `None` if the determinant is 0. The unit of t is `2^exponent`.
    fn truth(self, exponent: i64) -> Option<Truth> {
        let [t, u, v, det] = [self.t, self.u, self.v, self.det].map(Integer::big);
        if det == IBig::ZERO {
            return None;
        }
        let leaves = det > IBig::ZERO;
        let over = |num: IBig, exponent| Ratio {
            num: if leaves { num } else { -num },
            den: if leaves { det.clone() } else { -&det },
            exponent,
        };
        Some(Truth { t: over(t, exponent), u: over(u, 0), v: over(v, 0), leaves })
    }
}

/// Returns the scale of the origin and the corners, and the scale of the direction.
fn scales<S: Scalar>(ray: &RayOf<S>, triangle: &TriangleOf<S>) -> (Scale, Scale) {
    let [c1, c2, c3] = triangle.0;
    (Scale::of(&[ray.origin, c1, c2, c3]), Scale::of(&[ray.dir]))
}

/// Returns whether everything that [`IntegerPair`] computes fits in 128 bits. If points are below
/// `2^b`, differences are below `2^(b + 1)` and t is below `2^(3b + 6)`. If the direction is also
/// below `2^d`, everything else is below `2^(2b + d + 7)`.
fn are_small(points: &Scale, dir: &Scale) -> bool {
    points.bits <= 40 && dir.bits <= 39
}

/// Returns the intersection of the ray's line with the triangle's plane, if there is exactly one.
pub fn truth<S: Scalar>(ray: &RayOf<S>, triangle: &TriangleOf<S>) -> Option<Truth> {
    if !is_finite(ray, triangle) {
        return None;
    }
    let (points, dir) = scales(ray, triangle);
    if are_small(&points, &dir) {
        return truth_in::<S, i128>(ray, triangle, (points, dir));
    }
    truth_in::<S, IBig>(ray, triangle, (points, dir))
}

fn truth_in<S: Scalar, I: Integer>(
    ray: &RayOf<S>,
    triangle: &TriangleOf<S>,
    (points, dir): (Scale, Scale),
) -> Option<Truth> {
    let seen = IntegerPair::<I>::new(ray.origin, triangle, points.low);
    seen.along(&vector(ray.dir, dir.low)).truth(points.low - dir.low)
}

impl Truth {
    /// Returns the weights of the three corners, each multiplied by the positive denominator.
    fn weights(&self) -> [IBig; 3] {
        let (u, v) = (&self.u.num, &self.v.num);
        [&self.u.den - u - v, u.clone(), v.clone()]
    }

    /// Returns whether the point is in the closed triangle and not behind the origin.
    pub fn is_closed_hit(&self) -> bool {
        self.t.num > IBig::ZERO && self.weights().iter().all(|weight| *weight >= IBig::ZERO)
    }

    /// Returns the edges whose lines the ray meets: bit i stands for the edge opposite corner i + 1.
    pub fn edges(&self) -> u8 {
        let [a, b, c] = self.weights().map(|weight| u8::from(weight == IBig::ZERO));
        a | b << 1 | c << 2
    }

    /// Returns whether t is within the ray's interval.
    pub fn is_within<S: Scalar>(&self, ray: &RayOf<S>) -> bool {
        // Negative ends need no special case, because a hit also requires a positive t.
        let (near, far): (f64, f64) = (ray.t_min.into(), ray.t_max.into());
        let from = !near.is_finite() || self.t.cmp(near).is_ge();
        let to = !far.is_finite() || self.t.cmp(far).is_lt();
        near < far && from && to
    }

    /// Compares t with the t of another triangle on the same ray.
    pub fn order(&self, other: &Self) -> Ordering {
        let (a, b) = (&self.t, &other.t);
        let low = a.exponent.min(b.exponent);
        let over = |a: &Ratio, b: &Ratio| shifted(&a.num * &b.den, a.exponent - low);
        over(a, b).cmp(&over(b, a))
    }

    /// Returns whether three f64 numbers are t, u and v, each correctly rounded to nearest, with
    /// ties to even.
    pub fn are_rounded(&self, [t, u, v]: [f64; 3]) -> bool {
        let numbers = [(&self.t, t), (&self.u, u), (&self.v, v)];
        numbers.iter().all(|(exact, x)| exact.is_rounded(*x, &F64))
    }

    /// Returns whether three f32 numbers are t, u and v, each correctly rounded.
    pub fn are_rounded_to_f32(&self, [t, u, v]: [f32; 3]) -> bool {
        let numbers = [(&self.t, t), (&self.u, u), (&self.v, v)];
        numbers.iter().all(|(exact, x)| exact.is_rounded(f64::from(*x), &F32))
    }

    /// Returns an f64 near t.
    pub fn t_f64(&self) -> f64 {
        // Divide with more digits than an f64 has, then scale in two steps, because the power of
        // two may exceed the range of f64.
        let up = self.t.den.bit_len() as i64 - self.t.num.bit_len() as i64 + 60;
        let q = shifted(self.t.num.clone(), up.max(0)) / shifted(self.t.den.clone(), (-up).max(0));
        let (q, e) = (i64::try_from(q).unwrap() as f64, (self.t.exponent - up) as i32);
        q * 2.0_f64.powi(e / 2) * 2.0_f64.powi(e - e / 2)
    }
}

/// A binary floating-point format.
struct Format {
    digits: u32,
    /// The binary exponent of the smallest positive number.
    last: i64,
    /// The exponent of the smallest power of two that is too large for the format.
    top: i64,
}

const F64: Format = Format { digits: 53, last: -1074, top: 1024 };
const F32: Format = Format { digits: 24, last: -149, top: 128 };

impl Ratio {
    /// Compares the ratio with a finite number.
    fn cmp(&self, x: f64) -> Ordering {
        let (m, e) = parts(x);
        self.cmp_parts(m, e)
    }

    /// Compares the ratio with `m * 2^e`.
    fn cmp_parts(&self, m: i64, e: i64) -> Ordering {
        let low = self.exponent.min(e);
        let (left, right) = (shifted(self.num.clone(), self.exponent - low), &self.den * m);
        left.cmp(&shifted(right, e - low))
    }

    /// Returns whether `x` is the number in this format that is nearest to the ratio. If two
    /// numbers are equally near, `x` must be the even one.
    fn is_rounded(&self, x: f64, &Format { digits, last, top }: &Format) -> bool {
        let (m, e) = parts(x);
        // Ratios up to half of the smallest positive number round to zero. Ratios of at least the
        // largest number plus half an ulp of it round to infinity.
        if m == 0 {
            return self.cmp_parts(1, last - 1).is_le() && self.cmp_parts(-1, last - 1).is_ge();
        }
        if x.is_infinite() {
            let (beyond, sign) = ((2 << digits) - 1, if x > 0.0 { 1 } else { -1 });
            let order = self.cmp_parts(sign * beyond, top - i64::from(digits) - 1);
            return if x > 0.0 { order.is_ge() } else { order.is_le() };
        }
        if x.is_nan() {
            return false;
        }
        // Compare the ratio with the midpoints between `x` and its two neighbours: `inner` toward 0
        // and `outer` away from 0. Below a power of two, the spacing is half as large.
        let length = i64::from(64 - m.abs().leading_zeros());
        let exponent = (e + length - i64::from(digits)).max(last);
        let (sign, size) = (m.signum(), m.abs() >> (exponent - e));
        let e = exponent;
        let inner = if size == 1 << (digits - 1) && e > last { 4 * size - 1 } else { 4 * size - 2 };
        let inner = self.cmp_parts(sign * inner, e - 2);
        let outer = self.cmp_parts(sign * (4 * size + 2), e - 2);
        let (inner, outer) =
            if sign > 0 { (inner, outer) } else { (inner.reverse(), outer.reverse()) };
        let even = size & 1 == 0;
        if even { inner.is_ge() && outer.is_le() } else { inner.is_gt() && outer.is_lt() }
    }
}

/// The distance in bits between successive powers of ε in f32 scenes. It exceeds the difference in
/// length between any two terms.
const STEP: usize = 600;
/// The counterpart of [`STEP`] for f64 scenes.
const STEP_64: usize = 6500;

/// Returns how a ray crosses a triangle under the once rule: `Some(true)` in the direction of the
/// normal, `Some(false)` against it, and `None` if the ray does not cross the triangle. The
/// direction is moved by (ε, ε², ε³), where ε is so small that it affects only ties.
pub fn once<S: Scalar>(
    ray: &RayOf<S>,
    triangle: &TriangleOf<S>,
    truth: Option<&Truth>,
) -> Option<bool> {
    if !is_finite(ray, triangle) || ray.dir == [S::ZERO; 3] {
        return None;
    }
    // If the line passes strictly inside or strictly outside the triangle, moving the direction
    // does not change the result.
    if let Some(truth) = truth {
        let weights = truth.weights();
        if weights.iter().any(|weight| *weight < IBig::ZERO) {
            return None;
        }
        if weights.iter().all(|weight| *weight > IBig::ZERO) {
            return (truth.t.num > IBig::ZERO).then_some(truth.leaves);
        }
    }
    let (points, dir) = scales(ray, triangle);
    if are_small(&points, &dir) {
        return once_by_powers(ray, triangle, (points, dir));
    }
    once_moved(ray, triangle, (points, dir))
}

/// Computes [`once`] by actually moving the direction.
fn once_moved<S: Scalar>(
    ray: &RayOf<S>,
    triangle: &TriangleOf<S>,
    (points, dir): (Scale, Scale),
) -> Option<bool> {
    let step = if size_of::<S>() > size_of::<f32>() { STEP_64 } else { STEP };
    let mut moved = vector::<S, IBig>(ray.dir, dir.low);
    for (power, x) in (0..3).rev().zip(&mut moved) {
        *x = (x.clone() << (3 * step)) + (IBig::ONE << (power * step));
    }
    let seen = IntegerPair::<IBig>::new(ray.origin, triangle, points.low);
    let moved = seen.along(&moved).truth(points.low - dir.low)?;
    let weights = moved.weights();
    if weights.iter().any(|weight| *weight < IBig::ZERO) || moved.t.num <= IBig::ZERO {
        return None;
    }
    // Once the direction has been moved, the line no longer meets an edge.
    assert!(weights.iter().all(|weight| *weight > IBig::ZERO));
    Some(moved.leaves)
}

/// Computes [`once`] with polynomials: every value that is linear in the direction becomes a
/// polynomial in ε, whose sign is that of its first nonzero coefficient.
fn once_by_powers<S: Scalar>(
    ray: &RayOf<S>,
    triangle: &TriangleOf<S>,
    (points, dir): (Scale, Scale),
) -> Option<bool> {
    let seen = IntegerPair::<i128>::new(ray.origin, triangle, points.low);
    let axes = [[1, 0, 0], [0, 1, 0], [0, 0, 1]];
    let powers = [vector(ray.dir, dir.low), axes[0], axes[1], axes[2]].map(|d| seen.along(&d));
    let sign = |of: fn(&Cramer<i128>) -> i128| powers.each_ref().map(of).cmp(&[0; 4]);
    let leaves = sign(|x| x.det);
    let inside = [sign(|x| x.u), sign(|x| x.v), sign(|x| x.det - x.u - x.v), powers[0].t.cmp(&0)];
    (leaves.is_ne() && inside == [leaves; 4]).then(|| leaves.is_gt())
}

/// The integer type of a computation.
trait Integer: Sized {
    /// Returns `m * 2^by`, which must be an integer.
    fn of(m: i64, by: i64) -> Self;
    fn plus(&self, other: &Self) -> Self;
    fn minus(&self, other: &Self) -> Self;
    fn times(&self, other: &Self) -> Self;
    /// Returns this number as an arbitrary-precision integer.
    fn big(self) -> IBig;
}

impl Integer for IBig {
    fn of(m: i64, by: i64) -> Self {
        shifted(Self::from(m), by)
    }
    fn plus(&self, other: &Self) -> Self {
        self + other
    }
    fn minus(&self, other: &Self) -> Self {
        self - other
    }
    fn times(&self, other: &Self) -> Self {
        self * other
    }
    fn big(self) -> IBig {
        self
    }
}

impl Integer for i128 {
    fn of(m: i64, by: i64) -> Self {
        if by < 0 { Self::from(m >> -by) } else { Self::from(m) << by }
    }
    fn plus(&self, other: &Self) -> Self {
        self.checked_add(*other).unwrap()
    }
    fn minus(&self, other: &Self) -> Self {
        self.checked_sub(*other).unwrap()
    }
    fn times(&self, other: &Self) -> Self {
        self.checked_mul(*other).unwrap()
    }
    fn big(self) -> IBig {
        self.into()
    }
}

#[cfg(test)]
mod tests {
    use intertri::{Ray, Triangle};
    use intertri_lab::rng::Rng;

    use super::*;

    /// Compares 128-bit integers with arbitrary-precision integers, and polynomials in ε with
    /// actually moving the direction.
    #[test]
    fn both_routes_agree() {
        let (mut rng, mut small, mut crossed) = (Rng::new(5), 0, 0);
        for i in 0..200_000 {
            // The coordinates range from numbers with many trailing zeros to numbers for which the
            // results take up all 128 bits.
            let (size, scale) = (1 << (1 + i % 23), 2.0_f32.powi(i % 19));
            let mut number = || rng.within(size) as f32 * if rng.one_in(3) { scale } else { 1.0 };
            let mut vector = || [number(), number(), number()];
            let triangle = Triangle([vector(), vector(), vector()]);
            let ray = Ray::new(vector(), vector());
            let both = || scales(&ray, &triangle);
            let (points, dir) = both();
            if ray.dir == [0.0; 3] || !are_small(&points, &dir) {
                continue;
            }
            let parts = |truth: Option<Truth>| {
                let ratio = |r: Ratio| (r.num, r.den, r.exponent);
                truth.map(|Truth { t, u, v, leaves }| ([t, u, v].map(ratio), leaves))
            };
            let (of_128, of_any) = (
                truth_in::<_, i128>(&ray, &triangle, both()),
                truth_in::<_, IBig>(&ray, &triangle, both()),
            );
            assert_eq!(parts(of_128), parts(of_any), "{ray:?} {triangle:?}");
            let moved = once_moved(&ray, &triangle, both());
            assert_eq!(once_by_powers(&ray, &triangle, both()), moved, "{ray:?} {triangle:?}");
            small += 1;
            crossed += u32::from(moved.is_some());
        }
        assert!(small > 100_000 && crossed > 10_000, "{small} {crossed}");
    }
}
