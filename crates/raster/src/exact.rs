//! Exact arithmetic, for verdicts that must not depend on rounding.
//!
//! Every finite f32 and f64 is a rational number, and so are their sums, products, and quotients.
//! The sign of a sum with square roots can be found by squaring, so lengths can be compared too.

use std::cmp::Ordering;

use dashu_ratio::Relaxed;

/// A rational number.
pub(crate) type Exact = Relaxed;

/// A point or vector with rational coordinates.
pub(crate) type Point = [Exact; 3];

/// Converts a number exactly, or returns 0 if the number is not finite.
pub(crate) fn exact(x: f64) -> Exact {
    Exact::try_from(x).unwrap_or_default()
}

pub(crate) fn point<T: Into<f64>>(p: [T; 3]) -> Point {
    p.map(|x| exact(x.into()))
}

/// Rounds to the nearest f64.
pub(crate) fn rounded(x: &Exact) -> f64 {
    x.to_f64().value()
}

pub(crate) fn abs(x: Exact) -> Exact {
    if x < Exact::ZERO { -x } else { x }
}

pub(crate) fn add(a: &Point, b: &Point) -> Point {
    [&a[0] + &b[0], &a[1] + &b[1], &a[2] + &b[2]]
}

pub(crate) fn sub(a: &Point, b: &Point) -> Point {
    [&a[0] - &b[0], &a[1] - &b[1], &a[2] - &b[2]]
}

pub(crate) fn scale(a: &Point, s: &Exact) -> Point {
    [&a[0] * s, &a[1] * s, &a[2] * s]
}

pub(crate) fn dot(a: &Point, b: &Point) -> Exact {
    &a[0] * &b[0] + &a[1] * &b[1] + &a[2] * &b[2]
}

pub(crate) fn cross(a: &Point, b: &Point) -> Point {
    [&a[1] * &b[2] - &a[2] * &b[1], &a[2] * &b[0] - &a[0] * &b[2], &a[0] * &b[1] - &a[1] * &b[0]]
}

/// Returns |x| + |y| + |z|, a rational upper bound on the length.
pub(crate) fn size(a: &Point) -> Exact {
    a.iter().cloned().map(abs).fold(Exact::ZERO, |sum, x| sum + x)
}

fn sign(x: &Exact) -> Ordering {
    x.cmp(&Exact::ZERO)
}

/// Returns the sign of `a + b sqrt(p)`, where `p` is non-negative.
pub(crate) fn sign_with_root(a: &Exact, b: &Exact, p: &Exact) -> Ordering {
    stronger(sign(a), sign(b), || sign(&(a.sqr() - b.sqr() * p)), p)
}

/// Returns the sign of `a + b sqrt(p) + c sqrt(q)`, where `p` and `q` are non-negative.
pub(crate) fn sign_with_roots(a: &Exact, [b, p]: [&Exact; 2], [c, q]: [&Exact; 2]) -> Ordering {
    // (a + b sqrt(p))^2 - (c sqrt(q))^2 has only one root left.
    let squares = || {
        let rational = a.sqr() + b.sqr() * p - c.sqr() * q;
        sign_with_root(&rational, &(a * b * Exact::from(2)), p)
    };
    stronger(sign_with_root(a, b, p), sign(c), squares, q)
}

/// Returns the sign of `x + y sqrt(p)`, given the signs of x and y and, if the two are opposite,
/// the sign of `x^2 - y^2 p`.
fn stronger(x: Ordering, y: Ordering, squares: impl FnOnce() -> Ordering, p: &Exact) -> Ordering {
    let y = if p.is_zero() { Ordering::Equal } else { y };
    if y.is_eq() || x == y {
        x
    } else if x.is_eq() {
        y
    } else {
        match squares() {
            Ordering::Greater => x,
            Ordering::Equal => Ordering::Equal,
            Ordering::Less => y,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn roots(a: i32, b: i32, p: i32, c: i32, q: i32) -> Ordering {
        let [a, b, p, c, q] = [a, b, p, c, q].map(Exact::from);
        sign_with_roots(&a, [&b, &p], [&c, &q])
    }

    #[test]
    fn signs_of_roots_are_those_of_the_numbers() {
        let small = -3..=3;
        for (a, b) in small.clone().flat_map(|a| small.clone().map(move |b| (a, b))) {
            for (c, (p, q)) in small.clone().flat_map(|c| {
                (0..5).flat_map(|p| (0..5).map(move |q| (p, q))).map(move |pq| (c, pq))
            }) {
                let [x, y, z] = [a, b, c].map(f64::from);
                let value = x + y * f64::from(p).sqrt() + z * f64::from(q).sqrt();
                // For arguments that are small integers, the value is either 0 or far from 0.
                let expected = if value.abs() < 1e-9 { 0.0 } else { value };
                assert_eq!(roots(a, b, p, c, q), expected.total_cmp(&0.0), "{a} {b} {p} {c} {q}");
            }
        }
    }

    #[test]
    fn no_difference_is_too_small() {
        // Values that are exactly 0, and values that differ from 0 by only 2^-300.
        assert_eq!(roots(0, 1, 2, -1, 2), Ordering::Equal);
        let tiny = exact(2f64.powi(-300));
        let [one, two, four] = [1, 2, 4].map(Exact::from);
        assert_eq!(sign_with_root(&-&two, &one, &four), Ordering::Equal);
        assert_eq!(sign_with_root(&(&tiny - &two), &one, &four), Ordering::Greater);
        assert_eq!(sign_with_roots(&-&tiny, [&one, &two], [&-&one, &two]), Ordering::Less);
    }
}
