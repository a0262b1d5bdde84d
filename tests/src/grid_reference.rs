//! The scalar reference of the `fixed` mode, in i128: the test of one ray against one triangle, in
//! its simplest form.
//!
//! Let A, B, and C be the corners relative to the origin, and let d be the direction. The ray's
//! line passes through the inside of the triangle if the three determinants
//!
//! ```text
//!   U = d . (B x C)      V = d . (C x A)      W = d . (A x B)
//! ```
//!
//! have the same sign. The line meets the plane at `t = A . (B x C) / (U + V + W)`.

use std::cmp::Ordering;

use intertri::Hit;
use intertri::fixed::{Ray, Triangle};

/// Where a ray crosses a triangle.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Crossing {
    /// t in multiples of the snapped direction.
    pub t: Ratio,
    /// The weight of the second corner, times the denominator of t.
    pub v: u64,
    /// The weight of the third corner, times the denominator of t.
    pub w: u64,
    /// Whether the ray crosses in the direction of the normal.
    pub leaves: bool,
}

impl Crossing {
    /// Converts the crossing to f64, with `t` in multiples of the direction before snapping.
    pub fn to_hit(&self, ray: &Ray, triangle: u32) -> Hit {
        let weight = |num: u64| Ratio { num: num.into(), den: self.t.den }.to_f64(0);
        let (u, v) = (weight(self.v), weight(self.w));
        Hit { t: self.t.to_f64(ray.exponent()), u, v, triangle, geometry: 0 }
    }
}

/// Returns where a ray crosses a triangle, or `None` if it does not.
///
/// The complete rule is as follows. A determinant that is 0 takes the sign of the first nonzero
/// component of its cross product. The ray crosses if the three signs and the sign of `A . (B x C)`
/// are equal and nonzero, and if `t_min <= t < t_max`.
pub fn crossing(ray: &Ray, triangle: &Triangle) -> Option<Crossing> {
    let d = ray.dir().map(i128::from);
    let [a, b, c] = triangle
        .corners()
        .map(|corner| [0, 1, 2].map(|i| i128::from(corner[i]) - i128::from(ray.origin()[i])));

    let normals = [cross(b, c), cross(c, a), cross(a, b)];
    let volume = dot(a, normals[0]);
    let sign = volume.signum();
    if sign == 0 || normals.iter().any(|&n| moved_sign(d, n) != sign) {
        return None;
    }

    let [u, v, w] = normals.map(|n| dot(d, n).unsigned_abs() as u64);
    let t = Ratio { num: volume.unsigned_abs(), den: u + v + w };
    let line = ray.to_f32();
    let within = t.cmp_f32(line.t_min).is_some_and(Ordering::is_ge)
        && t.cmp_f32(line.t_max).is_some_and(Ordering::is_lt);
    within.then_some(Crossing { t, v, w, leaves: sign > 0 })
}

/// Returns all crossings of a ray, with the indices of the triangles, sorted by t and, for equal t,
/// by index.
pub fn crossings(ray: &Ray, triangles: &[Triangle]) -> Vec<(Crossing, u32)> {
    let crossing = |(triangle, index)| Some((crossing(ray, triangle)?, index));
    let mut all: Vec<_> = triangles.iter().zip(0..).filter_map(crossing).collect();
    all.sort_unstable_by_key(|(crossing, index)| (crossing.t, *index));
    all
}

/// Returns the sign of `(d + (e, e^2, e^3)) . n` for an arbitrarily small e.
fn moved_sign(d: [i128; 3], n: [i128; 3]) -> i128 {
    [dot(d, n), n[0], n[1], n[2]].into_iter().map(i128::signum).find(|&s| s != 0).unwrap_or(0)
}

fn dot(a: [i128; 3], b: [i128; 3]) -> i128 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

fn cross(a: [i128; 3], b: [i128; 3]) -> [i128; 3] {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

/// A positive t in multiples of the snapped direction: `num / den`, exact but not reduced. On any
/// grid, `num <= 2^64` and `den < 2^62`, so the product of one ratio's numerator and another's
/// denominator fits in 128 bits.
#[derive(Clone, Copy, Debug)]
pub struct Ratio {
    /// The numerator, which is positive.
    pub num: u128,
    /// The denominator, which is positive.
    pub den: u64,
}

impl Ratio {
    /// Converts `num / den * 2^exponent` to the nearest f64, ties to even.
    pub fn to_f64(self, exponent: i32) -> f64 {
        // A quotient of at least 56 bits, with a sticky bit for the remainder, rounds like the
        // ratio itself.
        let shift = (56 + bits(u128::from(self.den)) - bits(self.num)).max(0);
        let den = u128::from(self.den);
        let num = self.num << shift;
        let quotient = num / den;
        let sticky = u128::from(quotient * den != num);
        (quotient | sticky) as f64 * f64::from(exponent - shift).exp2()
    }

    /// Compares `num / den` with an f32 exactly. Returns `None` for NaN.
    pub fn cmp_f32(self, x: f32) -> Option<Ordering> {
        if x.is_nan() {
            return None;
        }
        if x <= 0.0 {
            return Some(Ordering::Greater);
        }
        if x == f32::INFINITY {
            return Some(Ordering::Less);
        }
        // Let x = m * 2^e, and compare num with m * den * 2^e.
        let field = (x.to_bits() >> 23) as i32;
        let fraction = x.to_bits() & 0x7f_ffff;
        let (m, shift) =
            if field == 0 { (fraction, -149) } else { (fraction | 1 << 23, field - 150) };
        let (left, right) = (self.num, u128::from(m) * u128::from(self.den));
        // If the bit lengths differ, they decide. If they are equal, the shift loses no bits.
        Some((bits(left)).cmp(&(bits(right) + shift)).then_with(|| {
            if shift < 0 { (left << -shift).cmp(&right) } else { left.cmp(&(right << shift)) }
        }))
    }
}

/// Ratios are equal if their values are, whether or not they are reduced.
impl PartialEq for Ratio {
    fn eq(&self, other: &Self) -> bool {
        self.cmp(other).is_eq()
    }
}
impl Eq for Ratio {}
impl PartialOrd for Ratio {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}
impl Ord for Ratio {
    fn cmp(&self, other: &Self) -> Ordering {
        (self.num * u128::from(other.den)).cmp(&(other.num * u128::from(self.den)))
    }
}

/// Returns the bit length of an integer.
fn bits(x: u128) -> i32 {
    128 - x.leading_zeros() as i32
}
