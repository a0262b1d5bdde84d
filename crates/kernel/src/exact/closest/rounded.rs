//! Distance and weights in numbers of twice the digits, with a proof of each rounding: what nearly every closest
//! point takes. Bounds and proof: `docs/numerics/nearest.md`, section 6.

use super::super::double::{Double, cross, difference, dot, product, sum};
use super::super::rounded::{DOUBT, Volume, quotient};
use super::closest_point::Closest;
use super::feature::Feature;
use crate::Triangle;
use crate::simd::{Lanes, Vec3};

/// Squares, numerators and denominators are within these where nothing can underflow.
const SMALL: f64 = f64::from_bits((1023 - 400) << 52);
const LARGE: f64 = f64::from_bits((1023 + 500) << 52);

/// The closest point, where all of it is proven. No number may be subnormal.
#[inline(always)]
pub(super) fn closest(point: [f32; 3], triangle: &Triangle, feature: Feature) -> Option<Closest> {
    let vec3 = |p: [f32; 3]| Vec3::<f64>::splat(p.map(f64::from));
    let (p, corners) = (vec3(point), triangle.0.map(vec3));
    let seen = |i: usize| exactly(corners[i], p);
    match feature {
        Feature::Corner(corner) => {
            let square = product_of(seen(corner)?, seen(corner)?);
            let weights = [1, 2].map(|other| if corner == other { 1.0 } else { 0.0 });
            Some(Closest { distance: root(rounded(&square)?)?, weights })
        }
        Feature::Edge(from) => {
            let to = (from + 1) % 3;
            let (x, y, edge) = (seen(from)?, seen(to)?, exactly(corners[to], corners[from])?);
            let den = Den::new(product_of(edge, edge))?;
            let area = cross(x, edge);
            let sizes = x.abs().permanents(edge.abs());
            let square = den.under(&squares(&area, sizes, &area, sizes))?;
            let minus = Vec3 { x: -edge.x, y: -edge.y, z: -edge.z };
            let of_from = || den.under(&product_of(y, edge));
            let of_to = || den.under(&product_of(x, minus));
            let weights = match from {
                0 => [of_to()?, 0.0],
                1 => [of_from()?, of_to()?],
                _ => [0.0, of_from()?],
            };
            Some(Closest { distance: root(square)?, weights })
        }
        Feature::Face => {
            let a = seen(0)?;
            let (ab, ac) = (exactly(corners[1], corners[0])?, exactly(corners[2], corners[0])?);
            let normal = cross(ab, ac);
            let sizes = ab.abs().permanents(ac.abs());
            let den = Den::new(squares(&normal, sizes, &normal, sizes))?;

            let volume = dot(&normal, a);
            let permanent = sizes.dot_fused(a.abs());
            let high = product(volume.high, volume.high);
            let twice = 2.0 * volume.high * volume.low;
            let size = Lanes::abs(volume.high);
            let num = Volume {
                value: sum(high.high, high.low + twice),
                err: (2.0 * size * permanent + high.high) * DOUBT,
            };
            let square = den.under(&num)?;

            let of_b = squares(&normal, sizes, &cross(ac, a), ac.abs().permanents(a.abs()));
            let of_c = squares(&normal, sizes, &cross(a, ab), a.abs().permanents(ab.abs()));
            let weights = [den.under(&of_b)?, den.under(&of_c)?];
            Some(Closest { distance: root(square)?, weights })
        }
    }
}

/// `a - b`, where f64 holds it.
#[inline(always)]
fn exactly(a: Vec3<f64>, b: Vec3<f64>) -> Option<Vec3<f64>> {
    let (difference, lacks) = difference(a, b);
    (lacks == 0.0).then_some(difference)
}

/// `a·b`
#[inline(always)]
fn product_of(a: Vec3<f64>, b: Vec3<f64>) -> Volume<f64> {
    let exact = |x: f64| Double { high: x, low: 0.0 };
    squares(
        &[exact(a.x), exact(a.y), exact(a.z)],
        a.abs(),
        &[exact(b.x), exact(b.y), exact(b.z)],
        b.abs(),
    )
}

/// The dot product of two vectors of which each component is within `3w²` of a size, and its low part within
/// `2.1w` of that: within `53w²` of the sum of products of sizes.
#[inline(always)]
fn squares(
    x: &[Double<f64>; 3],
    sizes: Vec3<f64>,
    y: &[Double<f64>; 3],
    other: Vec3<f64>,
) -> Volume<f64> {
    let part = |k: usize| {
        let high = product(x[k].high, y[k].high);
        Double { high: high.high, low: high.low + (x[k].high * y[k].low + x[k].low * y[k].high) }
    };
    let [a, b, c] = [part(0), part(1), part(2)];
    let two = sum(a.high, b.high);
    let three = sum(two.high, c.high);
    let low = (two.low + three.low) + ((a.low + b.low) + c.low);
    Volume { value: sum(three.high, low), err: sizes.dot_fused(other) * DOUBT }
}

/// A denominator.
struct Den {
    value: Volume<f64>,
    inverse: f64,
}

impl Den {
    #[inline(always)]
    fn new(value: Volume<f64>) -> Option<Self> {
        let high = value.value.high;
        (high > SMALL && high < LARGE).then(|| Self { inverse: 1.0 / high, value })
    }

    /// A positive quotient, rounded once.
    #[inline(always)]
    fn under(&self, num: &Volume<f64>) -> Option<f64> {
        let (q, sure) = quotient(num, &self.value, self.inverse);
        let high = num.value.high;
        (sure && high > SMALL && high < LARGE).then_some(q)
    }
}

/// A positive number, rounded once.
#[inline(always)]
fn rounded(of: &Volume<f64>) -> Option<f64> {
    let Volume { value: Double { high, low }, err } = *of;
    let (least, most) = (high + (low - err), high + (low + err));
    (least == most && high > SMALL && high < LARGE).then_some(most)
}

/// The root, rounded once.
#[inline(always)]
fn root(square: f64) -> Option<f64> {
    (square > 0.0).then(|| Lanes::sqrt(square))
}
