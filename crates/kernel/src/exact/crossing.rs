//! Whether a ray meets a triangle, by either rule.

use core::cmp::Ordering;

use super::float::{self, Decided};
use super::input::{is_finite, is_plain, pair};
use super::interval::Interval;
use super::numbers::{Numbers, Pair, Scales};
use super::quotient::Quotient;
use super::tier::{Tier, at_tier, is_f64};
use crate::packet::RayLanes;
use crate::simd::Vec3;
use crate::{RayOf, Scalar, TriangleOf};

/// Who owns an edge.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Rule {
    /// Each triangle that it belongs to: the ray meets the closed triangle.
    Closed,
    /// One of two neighbours that run along it in opposite directions: the ray is moved by (ε, ε², ε³).
    Once,
}

/// From which side a ray crosses a triangle.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Side {
    /// With the normal: out of a mesh whose corners run counter-clockwise as seen from outside.
    Leaves,
    /// Against the normal.
    Enters,
}

impl Side {
    /// 1 where the ray leaves, -1 where it enters: the sum over a closed mesh is its winding number.
    pub fn sign(self) -> i32 {
        match self {
            Self::Leaves => 1,
            Self::Enters => -1,
        }
    }
}

/// The side from which a ray crosses a triangle within its interval, if it does so by a rule; decided by
/// a tier or one behind it.
#[inline(always)]
pub fn crossing_from<S: Scalar>(
    from: Tier,
    rule: Rule,
    ray: &RayOf<S>,
    triangle: &TriangleOf<S>,
) -> Option<Side> {
    if from == Tier::Float && is_plain(ray, triangle) {
        let corners = triangle.0.map(|corner| Vec3::<f64>::splat(corner.map(Into::into)));
        let Decided { miss, closed, inside, leaves } =
            float::decide(corners, &RayLanes::of_ray(ray));
        if miss {
            return None;
        }
        if inside || rule == Rule::Closed && closed {
            return Some(if leaves { Side::Leaves } else { Side::Enters });
        }
    }
    by_integers(from, rule, ray, triangle)
}

/// Finds the widths.
#[inline(never)]
fn by_integers<S: Scalar>(
    from: Tier,
    rule: Rule,
    ray: &RayOf<S>,
    triangle: &TriangleOf<S>,
) -> Option<Side> {
    let interval = Interval::of(ray)?;
    if !is_finite(ray, triangle) {
        return None;
    }
    let pair = pair(ray, triangle);
    let scales = pair.scales();
    let tier = from.max(scales.tier::<S>());
    at_tier!(S, tier, crossing::<S, C, N, V>(rule, &pair, scales, interval))
}

fn crossing<S: Scalar, const C: usize, const N: usize, const V: usize>(
    rule: Rule,
    pair: &Pair<S>,
    scales: Scales,
    interval: Interval<S>,
) -> Option<Side> {
    let numbers = Numbers::<C, N, V>::new(pair, scales);
    let (edges, num) = (numbers.edges(), numbers.volume());

    // T has the side. On an edge the rule has the last word: the closed one takes either sign.
    let side = num.sign();
    let outside = edges.iter().zip(&numbers.normals).any(|(edge, [x, y, z])| {
        let moved = || x.sign().then_with(|| y.sign()).then_with(|| z.sign());
        let sign = edge.sign();
        let sign = if rule == Rule::Once { sign.then_with(moved) } else { sign };
        sign == side.reverse()
    });
    if outside || side.is_eq() {
        return None;
    }

    // Then D has that sign, too, but for a direction of 0.
    let den = edges[0] + edges[1] + edges[2];
    if den.sign().is_eq() {
        return None;
    }
    let t = || Quotient::new(&num.size(), &den.size(), scales.of_t());
    let side = if side == Ordering::Greater { Side::Leaves } else { Side::Enters };
    interval.contains(t).then_some(side)
}
