//! Decides whether a ray intersects a triangle, by either rule.

use core::cmp::Ordering;

use super::float::{self, Decided};
use super::input::{is_finite, is_plain, pair};
use super::interval::Interval;
use super::numbers::{Numbers, Pair, Scales};
use super::one_pair;
use super::quotient::Quotient;
use super::tier::{Tier, at_tier, is_f64};
use crate::packet::RayLanes;
use crate::simd::Vec3;
use crate::{RayOf, Scalar, TriangleOf};

/// The rule that determines which triangles own a shared edge or corner.
///
/// ```
/// use intertri::{Mode, Rule};
/// assert_eq!(Mode::once().rule(), Some(Rule::Once));
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Rule {
    /// Every triangle that contains the edge or corner: the ray is tested against the closed
    /// triangle.
    Closed,
    /// Only one of two adjacent triangles that traverse their shared edge in opposite directions.
    /// The ray is moved by (ε, ε², ε³).
    Once,
}

/// The side from which a ray crosses a triangle.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Side {
    /// In the direction of the normal. The ray then leaves a mesh whose corners run
    /// counter-clockwise as seen from outside.
    Leaves,
    /// Against the direction of the normal.
    Enters,
}

impl Side {
    /// Returns 1 if the ray leaves the mesh and -1 if it enters. The sum over a closed mesh is the
    /// winding number of the origin.
    pub fn sign(self) -> i32 {
        match self {
            Self::Leaves => 1,
            Self::Enters => -1,
        }
    }
}

/// Returns the side from which a ray crosses a triangle within its interval, if it does so by the
/// given rule. The computation starts at the given tier.
#[inline(always)]
pub fn crossing_from<S: Scalar>(
    from: Tier,
    rule: Rule,
    ray: &RayOf<S>,
    triangle: &TriangleOf<S>,
) -> Option<Side> {
    // Try f64 first, if rounding is its only error on this input.
    let plain = from == Tier::Float && is_plain(ray, triangle);
    if plain {
        if runs_along(ray, triangle) {
            return None;
        }
        let corners = triangle.0.map(|corner| Vec3::<f64>::splat(corner.map(Into::into)));
        let Decided { miss, closed, inside, leaves } =
            float::decide(corners, &RayLanes::of_ray(ray));
        if miss {
            return None;
        }
        // On an edge, the closed rule accepts the hit. The *once* rule must compare the normals,
        // which requires integers.
        if inside || rule == Rule::Closed && closed {
            return Some(if leaves { Side::Leaves } else { Side::Enters });
        }
    }
    by_integers(from, rule, ray, triangle, plain)
}

/// Returns whether a triangle is perpendicular to an axis and the ray runs parallel to its plane.
/// If so, D is 0, and the ray does not intersect the triangle. This case is common for walls and
/// floors. All volumes may be 0 in this case, which only integers could prove.
#[inline(always)]
fn runs_along<S: Scalar>(ray: &RayOf<S>, triangle: &TriangleOf<S>) -> bool {
    let [a, b, c] = triangle.0;
    (0..3).any(|k| ray.dir[k] == S::ZERO && a[k] == b[k] && b[k] == c[k])
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

/// Chooses the width of the integers. Plain inputs that need more than narrow integers are first
/// tried with two-part numbers, which are faster than wide integers.
#[inline(never)]
fn by_integers<S: Scalar>(
    from: Tier,
    rule: Rule,
    ray: &RayOf<S>,
    triangle: &TriangleOf<S>,
    plain: bool,
) -> Option<Side> {
    let interval = Interval::of(ray)?;
    if !is_finite(ray, triangle) {
        return None;
    }
    let pair = pair(ray, triangle);
    let scales = pair.scales();
    let tier = from.max(scales.tier());
    if const { is_f64::<S>() }
        && plain
        // Narrow integers are faster than two-part numbers, and always decide.
        && tier > Tier::Narrow
        && let Ok(decided) = in_two_parts(ray, triangle)
    {
        return decided;
    }
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
    interval.contains(t).then_some(side)
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
