//! Where along a ray a triangle lies that it is known to meet: t, the weights, and which of two comes first.

use core::cmp::Ordering;

use super::input::{is_plain, pair};
use super::int::Int;
use super::numbers::{Numbers, Pair, Scales};
use super::one_pair;
use super::quotient::Quotient;
use super::tier::{Tier, at_tier};
use crate::{Ray, Triangle};

/// t, rounded once, of a triangle whose plane the ray's line meets in one point; by a tier or one behind it.
#[inline(always)]
pub fn t_from(from: Tier, ray: &Ray, triangle: &Triangle) -> f64 {
    if from == Tier::Float && is_plain(ray, triangle) {
        let ([t, ..], sure) = one_pair::meet(ray, triangle);
        if sure & 1 != 0 {
            return t;
        }
    }
    t_by_integers(from, ray, triangle)
}

/// t, u and v, each rounded once, of a triangle whose plane the ray's line meets in one point; by a tier or
/// one behind it.
#[inline(always)]
pub fn attributes_from(from: Tier, ray: &Ray, triangle: &Triangle) -> (f64, f64, f64) {
    if from == Tier::Float && is_plain(ray, triangle) {
        let ([t, u, v], sure) = one_pair::meet(ray, triangle);
        if sure == 0b111 {
            return (t, u, v);
        }
    }
    attributes_by_integers(from, ray, triangle)
}

/// The order in which a ray meets two triangles, exactly; by a tier of integers or one behind it.
#[inline(never)]
pub fn order_from(from: Tier, ray: &Ray, one: &Triangle, other: &Triangle) -> Ordering {
    let (a, b) = (pair(ray, one), pair(ray, other));
    let scales = a.scales_with(other.0);
    at_tier!(from.max(scales.tier()), order::<C, N, V, P>(&a, &b, scales))
}

#[inline(never)]
fn t_by_integers(from: Tier, ray: &Ray, triangle: &Triangle) -> f64 {
    let pair = pair(ray, triangle);
    let scales = pair.scales();
    at_tier!(from.max(scales.tier()), t::<C, N, V>(&pair, scales))
}

#[inline(never)]
fn attributes_by_integers(from: Tier, ray: &Ray, triangle: &Triangle) -> (f64, f64, f64) {
    let pair = pair(ray, triangle);
    let scales = pair.scales();
    at_tier!(from.max(scales.tier()), attributes::<C, N, V>(&pair, scales))
}

fn t<const C: usize, const N: usize, const V: usize>(pair: &Pair<f32>, scales: Scales) -> f64 {
    let numbers = Numbers::<C, N, V>::new(pair, scales);
    let [u, v, w] = numbers.edges();
    ratio(&numbers.volume(), &(u + v + w), scales.of_t())
}

fn attributes<const C: usize, const N: usize, const V: usize>(
    pair: &Pair<f32>,
    scales: Scales,
) -> (f64, f64, f64) {
    let numbers = Numbers::<C, N, V>::new(pair, scales);
    let [u, v, w] = numbers.edges();
    let den = u + v + w;
    (ratio(&numbers.volume(), &den, scales.of_t()), ratio(&v, &den, 0), ratio(&w, &den, 0))
}

/// `num / den * 2^exponent`, rounded once.
fn ratio<const V: usize>(num: &Int<V>, den: &Int<V>, exponent: i32) -> f64 {
    if num.sign().is_eq() {
        return 0.0;
    }
    let size = Quotient::new(&num.size(), &den.size(), exponent).to_f64();
    if num.sign() == den.sign() { size } else { -size }
}

/// Both t are products with one power of two: over their denominators, they are multiplied crosswise.
fn order<const C: usize, const N: usize, const V: usize, const P: usize>(
    one: &Pair<f32>,
    other: &Pair<f32>,
    scales: Scales,
) -> Ordering {
    let t = |pair: &Pair<f32>| {
        let numbers = Numbers::<C, N, V>::new(pair, scales);
        let [u, v, w] = numbers.edges();
        (numbers.volume(), u + v + w)
    };
    let ((num, den), (other_num, other_den)) = (t(one), t(other));
    let order = num.times::<V, P>(&other_den).cmp(&other_num.times(&den));
    if den.sign() == other_den.sign() { order } else { order.reverse() }
}
