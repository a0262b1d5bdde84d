//! Computes the distance and the weights of a closest point in double-double arithmetic, and proves
//! each rounding. This method succeeds for nearly every point. `docs/numerics/nearest.md`, section
//! 6, has the bounds and the proof.

use core::marker::PhantomData;

use super::super::double::{Double, cross, dot, product, sum};
use super::super::rounded::{self, Volume, quotient};
use super::super::tails::{self, TwoParts, cross_tails, difference, times};
use super::super::tier::is_f64;
use super::closest_point::Closest;
use super::feature::Feature;
use crate::simd::{Lanes, Vec3};
use crate::{Scalar, TriangleOf};

/// `2^-400`: the lower limit for squares, numerators and denominators. Nothing underflows if they
/// are between this limit and [`LARGE`].
const SMALL: f64 = f64::from_bits((1023 - 400) << 52);
/// `2^500`: the upper limit for squares, numerators and denominators.
const LARGE: f64 = f64::from_bits((1023 + 500) << 52);

/// Returns the closest point if its distance and both weights are proven to be correctly rounded.
/// The input must be tame.
#[inline(always)]
pub(super) fn closest<S: Scalar>(
    point: [S; 3],
    triangle: &TriangleOf<S>,
    feature: Feature,
) -> Option<Closest> {
    let vec3 = |p: [S; 3]| Vec3::<f64>::splat(p.map(Into::into));
    let (p, corners) = (vec3(point), triangle.0.map(vec3));
    let seen = |i: usize| Offset::<S>::new(corners[i], p);
    match feature {
        Feature::Corner(corner) => {
            let a = seen(corner)?;
            let square = a.along(&a);
            // The weights of the second and third corners are 0 or 1.
            let weights = [1, 2].map(|other| if corner == other { 1.0 } else { 0.0 });
            Some(Closest { distance: root(proven(&square)?)?, weights })
        }
        Feature::Edge(from) => {
            let to = (from + 1) % 3;
            let (x, y, edge) = (seen(from)?, seen(to)?, Offset::new(corners[to], corners[from])?);
            let den = Den::new(edge.along(&edge))?;
            // The distance from a line is the area |x × edge| divided by the edge's length. Both
            // are squared here, so the root is taken only at the end.
            let area = x.cross(&edge);
            let square = den.under(&area.along(&area))?;
            // The weights of the foot are the projections of the two ends on the edge, divided by
            // the edge's squared length.
            let of_from = || den.under(&y.along(&edge));
            let of_to = || den.under(&x.along(&edge.negative()));
            let weights = match from {
                0 => [of_to()?, 0.0],
                1 => [of_from()?, of_to()?],
                _ => [0.0, of_from()?],
            };
            Some(Closest { distance: root(square)?, weights })
        }
        Feature::Face => {
            let a = seen(0)?;
            let ab = Offset::new(corners[1], corners[0])?;
            let ac = Offset::new(corners[2], corners[0])?;
            // The distance from the plane is the volume a·n divided by |n|. Both are squared here
            // as well.
            let normal = ab.cross(&ac);
            let den = Den::new(normal.along(&normal))?;
            let square = den.under(&normal.volume_squared(&a))?;
            let weights = [
                // The weights of the foot are the areas of the triangles that it forms with the
                // edges, projected on the normal.
                den.under(&normal.along(&ac.cross(&a)))?,
                den.under(&normal.along(&a.cross(&ab)))?,
            ];
            Some(Closest { distance: root(square)?, weights })
        }
    }
}

/// Returns twice a bound on the error of products, relative to the product of the magnitudes.
const fn doubt<S: Scalar>() -> f64 {
    if is_f64::<S>() { tails::DOUBT } else { rounded::DOUBT }
}

/// The difference of two given points: in two parts for f64, and exactly in one part for f32.
#[derive(Clone, Copy)]
struct Offset<S> {
    parts: TwoParts<f64>,
    given: PhantomData<S>,
}

/// A vector of double-double numbers, and the magnitudes that its error is relative to.
struct Long<S> {
    parts: [Double<f64>; 3],
    sizes: Vec3<f64>,
    given: PhantomData<S>,
}

impl<S: Scalar> Offset<S> {
    /// Computes `a - b`.
    #[inline(always)]
    fn new(a: Vec3<f64>, b: Vec3<f64>) -> Option<Self> {
        let parts = difference(a, b);
        let lacks = parts.rest.abs();
        // The bound for f32 does not include errors of differences, so differences that are not
        // exact in f64 are left to the integers.
        let is_exact = lacks.x + lacks.y + lacks.z == 0.0;
        (const { is_f64::<S>() } || is_exact).then_some(Self { parts, given: PhantomData })
    }

    /// Returns the cross product.
    #[inline(always)]
    fn cross(&self, by: &Self) -> Long<S> {
        let (a, b) = (self.parts.first, by.parts.first);
        let parts =
            if const { is_f64::<S>() } { cross_tails(&self.parts, &by.parts) } else { cross(a, b) };
        Long { parts, sizes: a.abs().permanents(b.abs()), given: PhantomData }
    }

    /// Returns the dot product.
    #[inline(always)]
    fn along(&self, by: &Self) -> Volume<f64> {
        self.long().along(&by.long())
    }

    #[inline(always)]
    fn long(&self) -> Long<S> {
        let TwoParts { first, rest } = self.parts;
        let low = |x: f64| if const { is_f64::<S>() } { x } else { 0.0 };
        let part = |high: f64, rest: f64| Double { high, low: low(rest) };
        let parts = [part(first.x, rest.x), part(first.y, rest.y), part(first.z, rest.z)];
        Long { parts, sizes: first.abs(), given: PhantomData }
    }

    #[inline(always)]
    fn negative(&self) -> Self {
        let minus = |v: Vec3<f64>| Vec3 { x: -v.x, y: -v.y, z: -v.z };
        let TwoParts { first, rest } = self.parts;
        Self { parts: TwoParts { first: minus(first), rest: minus(rest) }, given: PhantomData }
    }
}

impl<S: Scalar> Long<S> {
    /// Returns the dot product. Its error is less than half of [`doubt`] times the sum of the
    /// products of magnitudes.
    #[inline(always)]
    fn along(&self, by: &Self) -> Volume<f64> {
        let (x, y) = (&self.parts, &by.parts);
        let part = |k: usize| {
            let high = product(x[k].high, y[k].high);
            // The product low × low is of the order of w², where w is half an ulp of 1, and is
            // included in the bound.
            let low = high.low + (x[k].high * y[k].low + x[k].low * y[k].high);
            Double { high: high.high, low }
        };
        let [a, b, c] = [part(0), part(1), part(2)];
        let two = sum(a.high, b.high);
        let three = sum(two.high, c.high);
        let low = (two.low + three.low) + ((a.low + b.low) + c.low);
        let err = self.sizes.dot_fused(by.sizes) * const { doubt::<S>() };
        Volume { value: sum(three.high, low), err }
    }

    /// Returns the square of the volume that the vector spans with a corner.
    #[inline(always)]
    fn volume_squared(&self, corner: &Offset<S>) -> Volume<f64> {
        let TwoParts { first, .. } = corner.parts;
        let volume = if const { is_f64::<S>() } {
            times(&self.parts, &corner.parts)
        } else {
            dot(&self.parts, first)
        };
        let permanent = self.sizes.dot_fused(first.abs());
        let high = product(volume.high, volume.high);
        // (high + low)² = high² + 2 high low + low², where the last term is included in the bound.
        let twice = 2.0 * volume.high * volume.low;
        let size = Lanes::abs(volume.high);
        let err = (2.0 * size * permanent + high.high) * const { doubt::<S>() };
        Volume { value: sum(high.high, high.low + twice), err }
    }
}

/// A denominator and its approximate inverse.
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

    /// Returns a positive quotient, if its correct rounding is proven.
    #[inline(always)]
    fn under(&self, num: &Volume<f64>) -> Option<f64> {
        let (q, sure) = quotient(num, &self.value, self.inverse);
        let high = num.value.high;
        (sure && high > SMALL && high < LARGE).then_some(q)
    }
}

/// Returns a positive number, if its correct rounding is proven.
#[inline(always)]
fn proven(of: &Volume<f64>) -> Option<f64> {
    let Volume { value: Double { high, low }, err } = *of;
    // Rounding preserves order: if both ends round to the same number, so does every number in
    // between.
    let (least, most) = (high + (low - err), high + (low + err));
    (least == most && high > SMALL && high < LARGE).then_some(most)
}

/// Returns the correctly rounded square root.
#[inline(always)]
fn root(square: f64) -> Option<f64> {
    (square > 0.0).then(|| Lanes::sqrt(square))
}
