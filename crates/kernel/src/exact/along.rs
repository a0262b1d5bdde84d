//! The intersection of a ray with a triangle that it is known to hit: t, the weights, and the order
//! of two triangles along the ray.

use core::cmp::Ordering;

use super::input::is_plain;
use super::int::Int;
use super::numbers::{Numbers, Pair};
use super::one_pair::{self, Intersection};
use super::quotient::{Quotient, pow2};
use super::scale::Scales;
use super::tier::{Tier, at_tier};
use crate::{RayOf, Scalar, TriangleOf};

/// Returns the correctly rounded t of a triangle whose plane the ray's line intersects in one
/// point. The computation starts at the given tier.
#[inline(always)]
pub fn t_from<S: Scalar>(from: Tier, ray: &RayOf<S>, triangle: &TriangleOf<S>) -> f64 {
    t_times_from(from, ray, triangle, 0)
}

/// Returns the correctly rounded `t * 2^exponent` for a triangle whose plane the ray's line
/// intersects in one point. The computation starts at the given tier.
#[inline(always)]
pub(crate) fn t_times_from<S: Scalar>(
    from: Tier,
    ray: &RayOf<S>,
    triangle: &TriangleOf<S>,
    exponent: i32,
) -> f64 {
    if from == Tier::Float && is_plain(ray, triangle) {
        let Intersection { quotients: [t, ..], sure, .. } = one_pair::meet(ray, triangle);
        // Bit 0 stands for t, and bits 1 and 2 for u and v.
        let is_sure = sure & 1 != 0;
        if is_sure && exponent == 0 {
            return t;
        }
        // Both factors and the product are normal numbers, so the product is exact.
        if is_sure && is_tame_t(t) && exponent.unsigned_abs() < 500 {
            return t * pow2(exponent);
        }
    }
    t_by_integers(from, ray, triangle, exponent)
}

/// Returns whether t is far from the limits of f64's exponents.
#[inline(always)]
fn is_tame_t(t: f64) -> bool {
    (pow2(-500)..=pow2(500)).contains(&t)
}

#[inline(never)]
fn t_by_integers<S: Scalar>(
    from: Tier,
    ray: &RayOf<S>,
    triangle: &TriangleOf<S>,
    exponent: i32,
) -> f64 {
    let [t, ..] = Ratio::of_pair(from, &Pair::new(ray, triangle), 0b001);
    // Scaling by a power of two comes before the only rounding, so the result is rounded once even
    // if it is subnormal.
    t.times_pow2(exponent).to_f64()
}

/// Returns the correctly rounded t, u and v of a triangle whose plane the ray's line intersects in
/// one point. The computation starts at the given tier.
#[inline(always)]
pub fn attributes_from<S: Scalar>(
    from: Tier,
    ray: &RayOf<S>,
    triangle: &TriangleOf<S>,
) -> (f64, f64, f64) {
    let mut known = ([0.0; 3], 0);
    if from == Tier::Float && is_plain(ray, triangle) {
        let Intersection { quotients: [t, u, v], sure, .. } = one_pair::meet(ray, triangle);
        if sure == 0b111 {
            return (t, u, v);
        }
        known = ([t, u, v], sure);
    }
    attributes_by_integers(from, ray, triangle, known)
}

/// Computes t, u and v, correctly rounded to f32, for a triangle whose plane the ray's line
/// intersects in one point.
#[inline(never)]
pub fn attributes32<S: Scalar>(ray: &RayOf<S>, triangle: &TriangleOf<S>) -> [f32; 3] {
    let (t, u, v) = attributes_from(Tier::Float, ray, triangle);
    narrowed([t, u, v]).unwrap_or_else(|| attributes32_by_integers(ray, triangle))
}

/// Takes f64 values that were correctly rounded from exact numbers, and returns the exact numbers
/// correctly rounded to f32. Returns `None` if the f64 values do not determine the results.
///
/// Rounding preserves order. If both f64 neighbours of a value round to the same f32, so does every
/// real number that rounds to the value. Next to the midpoint of two f32 values, the neighbours
/// round to different values.
#[inline(always)]
pub(super) fn narrowed(numbers: [f64; 3]) -> Option<[f32; 3]> {
    let [t, u, v] = numbers.map(
        #[inline(always)]
        |x| {
            // The neighbours of numbers other than 0 have neighbouring bits.
            let bits = x.to_bits();
            let [one, other] = [bits.wrapping_sub(1), bits.wrapping_add(1)].map(f64::from_bits);
            // The CPU may be set to turn subnormal results into 0.
            let is_same = x.abs() >= NORMAL && one as f32 == other as f32;
            (is_same || x == 0.0).then_some(x as f32)
        },
    );
    Some([t?, u?, v?])
}

/// `2^-125`: a number of at least this magnitude never rounds to a subnormal f32.
pub(super) const NORMAL: f64 = 2.0 * f32::MIN_POSITIVE as f64;

#[cold]
#[inline(never)]
pub(super) fn attributes32_by_integers<S: Scalar>(
    ray: &RayOf<S>,
    triangle: &TriangleOf<S>,
) -> [f32; 3] {
    Ratio::of_pair(Tier::Float, &Pair::new(ray, triangle), 0b111).map(Ratio::to_f32)
}

/// Returns the exact order in which a ray hits two triangles. The computation starts at the given
/// tier of integers.
pub fn order_from<S: Scalar>(
    from: Tier,
    ray: &RayOf<S>,
    one: &TriangleOf<S>,
    other: &TriangleOf<S>,
) -> Ordering {
    order_by_integers(from, &Pair::new(ray, one), &Pair::new(ray, other))
}

#[inline(never)]
fn order_by_integers(from: Tier, one: &Pair, other: &Pair) -> Ordering {
    let scales = one.scales_with(other);
    at_tier!(from.max(scales.tier()), order::<C, N, V, P>(one, other, scales))
}

/// Computes, in integers, whichever of t, u and v are not yet known. A weight of 0, at a point on
/// an edge, cannot be proven by a bound, so it is computed here.
#[inline(never)]
fn attributes_by_integers<S: Scalar>(
    from: Tier,
    ray: &RayOf<S>,
    triangle: &TriangleOf<S>,
    known: ([f64; 3], u32),
) -> (f64, f64, f64) {
    let (known, sure) = known;
    let ratios = Ratio::of_pair(from, &Pair::new(ray, triangle), !sure);
    let number = |i: usize| if sure >> i & 1 != 0 { known[i] } else { ratios[i].to_f64() };
    (number(0), number(1), number(2))
}

/// A quotient of two integers with its sign.
#[derive(Clone, Copy)]
struct Ratio {
    /// The magnitude, or `None` if the quotient is 0.
    size: Option<Quotient>,
    is_negative: bool,
}

impl Ratio {
    /// Returns t, u, and v of a pair. Bit i of `wanted` is set if the i-th is needed; the others are
    /// 0. The computation starts at the given tier.
    #[inline(never)]
    fn of_pair(from: Tier, pair: &Pair, wanted: u32) -> [Self; 3] {
        let scales = pair.scales();
        at_tier!(from.max(scales.tier()), ratios::<C, N, V>(pair, scales, wanted))
    }

    /// Multiplies by a power of two.
    fn times_pow2(self, exponent: i32) -> Self {
        Self { size: self.size.map(|size| size.times_pow2(exponent)), ..self }
    }

    /// Rounds to the nearest f64.
    fn to_f64(self) -> f64 {
        // Return a positive 0, as every tier does.
        let size = self.size.map_or(0.0, Quotient::to_f64);
        if self.is_negative { -size } else { size }
    }

    /// Rounds to the nearest f32.
    fn to_f32(self) -> f32 {
        let size = self.size.map_or(0.0, Quotient::to_f32);
        // A result of 0 is always positive.
        if self.is_negative && size != 0.0 { -size } else { size }
    }
}

fn ratios<const C: usize, const N: usize, const V: usize>(
    pair: &Pair,
    scales: Scales,
    wanted: u32,
) -> [Ratio; 3] {
    let numbers = Numbers::<C, N, V>::new(pair, scales);
    let [u, v, w] = numbers.edges();
    let den = u + v + w;
    let over_den = |i: u32, num: Int<V>, exponent| {
        let some = wanted >> i & 1 != 0 && num.sign().is_ne();
        let size = some.then(|| Quotient::new(&num.size(), &den.size(), exponent));
        Ratio { size, is_negative: some && num.sign() != den.sign() }
    };
    [over_den(0, numbers.volume(), scales.of_t()), over_den(1, v, 0), over_den(2, w, 0)]
}

/// Compares the values of t for two triangles by cross-multiplying with the denominators. At common
/// scales, both quotients are multiplied by the same power of two, which cancels.
fn order<const C: usize, const N: usize, const V: usize, const P: usize>(
    one: &Pair,
    other: &Pair,
    scales: Scales,
) -> Ordering {
    let t = |pair: &Pair| {
        let numbers = Numbers::<C, N, V>::new(pair, scales);
        let [u, v, w] = numbers.edges();
        (numbers.volume(), u + v + w)
    };
    let ((num, den), (other_num, other_den)) = (t(one), t(other));
    // If d and d' have the same sign, n/d < n'/d' is equivalent to n d' < n' d; if their signs
    // differ, the inequality is reversed.
    let order = num.times::<V, P>(&other_den).cmp(&other_num.times(&den));
    if den.sign() == other_den.sign() { order } else { order.reverse() }
}

#[cfg(test)]
mod tests {
    use super::attributes32;
    use crate::{Ray, Triangle};

    /// In this test, t is the mean of three heights, `1 + k 2^-24 + tiny`, which for odd k is next
    /// to the midpoint of two f32 values. In f64, the sum loses `tiny`, so rounding to f64 and then
    /// to f32 would change half of the results by one step.
    #[test]
    fn numbers_near_half_way_are_rounded_once() {
        let tiny = 2.0_f32.powi(-70);
        for (k, tiny, steps) in
            [(1, -tiny, 0), (1, tiny, 1), (3, -tiny, 1), (3, tiny, 2), (3, 0.0, 2)]
        {
            let heights = [0.5 + 3.0 * k as f32 * 2.0_f32.powi(-24), 3.0 * tiny, 2.5];
            let corners = [[-1.0, -1.0], [2.0, -1.0], [-1.0, 2.0]];
            let corner = |i: usize| [corners[i][0], corners[i][1], heights[i]];
            let (ray, triangle) =
                (Ray::new([0.0; 3], [0.0, 0.0, 1.0]), Triangle([0, 1, 2].map(corner)));
            let [t, ..] = attributes32(&ray, &triangle);
            assert_eq!(t, 1.0 + steps as f32 * f32::EPSILON, "{k}, {tiny}");
        }
    }
}
