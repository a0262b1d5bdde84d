//! Decides whether a ray intersects a triangle under either rule.

use core::cmp::Ordering;

use super::decision::{InFloat, PairDecision, Rule, Side, in_float};
use super::input::is_finite;
use super::interval::Interval;
use super::numbers::{Numbers, Pair};
use super::one_pair;
use super::quotient::Quotient;
use super::scale::Scales;
use super::tier::{Tier, at_tier, is_f64};
use crate::{RayOf, Scalar, TriangleOf};

/// Returns the side from which a ray crosses a triangle within its interval, if it does so under
/// the given rule. The computation starts at the given tier.
#[inline(always)]
pub fn crossing_from<S: Scalar>(
    from: Tier,
    rule: Rule,
    ray: &RayOf<S>,
    triangle: &TriangleOf<S>,
) -> Option<Side> {
    let mut plain = false;
    if from == Tier::Float {
        match in_float(rule, ray, triangle) {
            InFloat::Miss => return None,
            InFloat::Hit(side, ..) => return Some(side),
            InFloat::Undecided { t } => plain = t.is_some(),
        }
    }
    by_integers(from, rule, ray, triangle, plain).map(|(side, _)| side)
}

/// Decides whether a ray hits a triangle within its interval, and about where.
pub fn decide_pair<S: Scalar>(
    rule: Rule,
    ray: &RayOf<S>,
    triangle: &TriangleOf<S>,
) -> PairDecision {
    match in_float(rule, ray, triangle) {
        InFloat::Miss => PairDecision::Miss,
        InFloat::Hit(_, [lo, hi], edges) => PairDecision::hit_within(lo, hi, edges),
        InFloat::Undecided { t } => {
            match (by_integers(Tier::Float, rule, ray, triangle, t.is_some()), t) {
                (None, _) => PairDecision::Miss,
                (Some((_, edges)), Some([lo, hi])) => PairDecision::hit_within(lo, hi, edges),
                (Some(_), None) => PairDecision::HIT_ANYWHERE,
            }
        }
    }
}

/// The error for a case that two-part numbers cannot decide.
struct Undecided;

/// Decides with two-part numbers. Rays that hit an edge or an end of the interval stay undecided,
/// as do all other cases that two-part numbers cannot prove.
#[inline(never)]
fn in_two_parts<S: Scalar>(
    ray: &RayOf<S>,
    triangle: &TriangleOf<S>,
) -> Result<Option<Side>, Undecided> {
    let met = one_pair::meet(ray, triangle);
    let signs = met.signs();
    if signs.contains(&1) && signs.contains(&-1) {
        return Ok(None);
    }
    // If no sign is 0, the point is inside all edges. A sign of 0 is undecided, because the ray
    // hits an edge exactly or nearly. The interval comes next: rounding preserves order, so the
    // rounded t may be compared.
    if signs.contains(&0) || met.sure & 1 == 0 {
        return Err(Undecided);
    }
    let (t, t_min, t_max): (f64, f64, f64) = (met.quotients[0], ray.t_min.into(), ray.t_max.into());
    if t < t_min || t > t_max {
        return Ok(None);
    }
    let side = if signs[0] > 0 { Side::Leaves } else { Side::Enters };
    if t > t_min && t < t_max { Ok(Some(side)) } else { Err(Undecided) }
}

/// The side from which a ray crosses a triangle, and the edges on which it certainly meets it
/// ([`PairDecision::Hit`]).
type Crossed = (Side, u8);

/// Chooses the width of the integers. Plain inputs that need more than narrow integers are first
/// tried with two-part numbers, which are faster than wide integers.
#[inline(never)]
fn by_integers<S: Scalar>(
    from: Tier,
    rule: Rule,
    ray: &RayOf<S>,
    triangle: &TriangleOf<S>,
    plain: bool,
) -> Option<Crossed> {
    let interval = Interval::of(ray)?;
    if !is_finite(ray, triangle) {
        return None;
    }
    let pair = Pair::new(ray, triangle);
    let scales = pair.scales();
    let tier = from.max(scales.tier());
    if const { is_f64::<S>() }
        && plain
        // Narrow integers are faster than two-part numbers, and always decide.
        && tier > Tier::Narrow
        && let Ok(decided) = in_two_parts(ray, triangle)
    {
        return decided.map(|side| (side, 0));
    }
    crossing_at(tier, rule, &pair, scales, interval)
}

#[inline(never)]
fn crossing_at(
    tier: Tier,
    rule: Rule,
    pair: &Pair,
    scales: Scales,
    interval: Interval,
) -> Option<Crossed> {
    at_tier!(tier, crossing::<C, N, V>(rule, pair, scales, interval))
}

fn crossing<const C: usize, const N: usize, const V: usize>(
    rule: Rule,
    pair: &Pair,
    scales: Scales,
    interval: Interval,
) -> Option<Crossed> {
    let numbers = Numbers::<C, N, V>::new(pair, scales);
    let (edges, num) = (numbers.edges(), numbers.volume());

    // The sign of T determines the side. On an edge, the rule decides: the closed rule accepts
    // either sign.
    let side = num.sign();
    let outside = edges.iter().zip(&numbers.normals).any(|(edge, [x, y, z])| {
        // A ray on the edge is moved by (ε, ε², ε³). The sign is then that of the first nonzero
        // component of N.
        let moved = || x.sign().then_with(|| y.sign()).then_with(|| z.sign());
        let sign = edge.sign();
        let sign = if rule == Rule::Once { sign.then_with(moved) } else { sign };
        sign == side.reverse()
    });
    if outside || side.is_eq() {
        return None;
    }

    // D then has the same sign, except for a zero direction.
    let den = edges[0] + edges[1] + edges[2];
    if den.sign().is_eq() {
        return None;
    }
    let t = || Quotient::new(&num.size(), &den.size(), scales.of_t());
    let side = if side == Ordering::Greater { Side::Leaves } else { Side::Enters };
    let [u, v, w] = edges.map(|edge| u8::from(edge.sign().is_eq()));
    interval.contains(t).then_some((side, u | v << 1 | w << 2))
}

#[cfg(test)]
mod tests {
    use super::{Rule, crossing_from, in_two_parts};
    use crate::exact::Tier;
    use crate::exact::test_numbers::random;
    use crate::{Ray, Ray64, Triangle, TriangleOf};

    /// Tests rays that lie in an axis-aligned wall or are parallel to one, including cases in which
    /// the ray or the wall is slightly tilted. The fast path must agree with integers.
    #[test]
    fn rays_along_a_wall_are_answered_as_by_integers() {
        let (mut random, mut hits) = (random(), 0);
        for i in 0..30_000 {
            let k = i % 3;
            let wall = 2.0 * random() as f32;
            let mut point = || [0; 3].map(|_| random() as f32);
            let (mut corners, mut origin, mut dir) =
                ([point(), point(), point()], point(), point());
            for corner in &mut corners {
                corner[k] = wall;
            }
            match i / 3 % 6 {
                0 => (origin[k], dir[k]) = (wall, 0.0),
                1 => dir[k] = -0.0,
                2 => (origin[k], dir[k], corners[i % 3][k]) = (wall, 0.0, wall.next_up()),
                3 => (dir[k], corners[2][k]) = (0.0, origin[k]),
                4 => (origin[k], dir[k]) = (wall, 1e-30),
                _ => dir = [0, 1, 2].map(|j| corners[0][j] - origin[j]),
            }
            let (ray, triangle) = (Ray::new(origin, dir), Triangle(corners));
            for rule in [Rule::Closed, Rule::Once] {
                let at_once = crossing_from(Tier::Float, rule, &ray, &triangle);
                assert_eq!(at_once, crossing_from(Tier::Narrow, rule, &ray, &triangle), "{ray:?}");
                hits += u32::from(at_once.is_some());
            }
        }
        assert!(hits > 1000, "{hits} hits");
    }

    /// Tests rays that are aimed at edges, up to rounding. The differences between the points are
    /// often not exact in f64.
    #[test]
    fn two_parts_say_what_integers_say() {
        let mut random = random();
        let (mut decided, mut hits) = (0, 0);
        for i in 0..5000 {
            let mut point = || [0; 3].map(|_| random() * (4000.0 * (random() + 0.51)).powi(2));
            let (corners, origin, part) = ([point(), point(), point()], point(), 0.5 + random());
            let (a, b) = (corners[i % 3], corners[(i + 1) % 3]);
            // Aim at a point on an edge, up to rounding.
            let dir = [0, 1, 2].map(|k| a[k] + part * (b[k] - a[k]) - origin[k]);
            let (ray, triangle) = (Ray64::new(origin, dir), TriangleOf(corners));
            let Ok(said) = in_two_parts(&ray, &triangle) else { continue };
            assert_eq!(said, crossing_from(Tier::Narrow, Rule::Closed, &ray, &triangle), "{ray:?}");
            assert_eq!(said, crossing_from(Tier::Narrow, Rule::Once, &ray, &triangle), "{ray:?}");
            decided += 1;
            hits += u32::from(said.is_some());
        }
        assert!(decided > 4900 && hits > 1000 && hits < 4000, "{decided} decided, {hits} hits");
    }
}
