//! Decides whether a ray intersects a triangle under either rule.

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

/// What f64 can say about a ray and a triangle.
enum InFloat {
    /// The ray misses the triangle, or hits it outside its interval.
    Miss,
    /// The ray hits the triangle within its interval, on this side and with t between these bounds.
    Hit(Side, [f64; 2]),
    /// Only integers can decide. `plain` tells whether rounding is the only error of f64.
    Undecided { plain: bool },
}

/// Decides whether a ray hits a triangle within its interval, if f64 and its error bound suffice.
#[inline(always)]
fn in_float<S: Scalar>(rule: Rule, ray: &RayOf<S>, triangle: &TriangleOf<S>) -> InFloat {
    if !is_plain(ray, triangle) {
        return InFloat::Undecided { plain: false };
    }
    if runs_along(ray, triangle) {
        return InFloat::Miss;
    }
    let corners = triangle.0.map(|corner| Vec3::<f64>::splat(corner.map(Into::into)));
    let (Decided { miss, closed, inside, leaves }, t) =
        float::decide_with_t(corners, &RayLanes::of_ray(ray));
    if miss {
        return InFloat::Miss;
    }
    // On an edge, the closed rule accepts the hit. The *once* rule must compare the normals, which
    // requires integers.
    if inside || rule == Rule::Closed && closed {
        return InFloat::Hit(if leaves { Side::Leaves } else { Side::Enters }, t);
    }
    InFloat::Undecided { plain: true }
}

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
            InFloat::Hit(side, _) => return Some(side),
            InFloat::Undecided { plain: is_plain } => plain = is_plain,
        }
    }
    by_integers(from, rule, ray, triangle, plain)
}

/// What f64 and its error bound decide about a ray and a triangle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum PairDecision {
    /// The ray does not hit the triangle within its interval.
    Miss,
    /// The ray hits the triangle within its interval, and t is in `t_lo..=t_hi`. If t has no useful
    /// bounds, they are 0 and infinity.
    Hit {
        /// The lower bound on t.
        t_lo: f32,
        /// The upper bound on t.
        t_hi: f32,
    },
    /// The error bound decides nothing.
    Undecided,
}

impl PairDecision {
    /// A hit whose t has no bounds.
    pub const HIT_ANYWHERE: Self = Self::Hit { t_lo: 0.0, t_hi: f32::INFINITY };
}

/// Decides whether a ray hits a triangle within its interval, and about where, if f64 and its error
/// bound suffice.
pub fn decide_pair<S: Scalar>(
    rule: Rule,
    ray: &RayOf<S>,
    triangle: &TriangleOf<S>,
) -> PairDecision {
    match in_float(rule, ray, triangle) {
        InFloat::Miss => PairDecision::Miss,
        InFloat::Undecided { .. } => PairDecision::Undecided,
        InFloat::Hit(_, [lo, hi]) => {
            // If the error of D can exceed D, `hi` is infinite or negative. Bounds that are far
            // apart would not help, and f32 bounds near the limits of f32 may overflow or become 0.
            let are_close = hi >= lo && hi - lo <= lo * CLOSE;
            if !(are_close && lo >= LIMITS[0] && hi <= LIMITS[1]) {
                return PairDecision::HIT_ANYWHERE;
            }
            PairDecision::Hit { t_lo: f32_bounds(lo).0, t_hi: f32_bounds(hi).1 }
        }
    }
}

/// Returns whether a ray hits a triangle within its interval, for a pair that [`decide_pair`] has
/// left undecided.
pub fn hit_undecided<S: Scalar>(rule: Rule, ray: &RayOf<S>, triangle: &TriangleOf<S>) -> bool {
    // For f32, integers do not use this.
    let plain = const { is_f64::<S>() } && is_plain(ray, triangle);
    by_integers(Tier::Float, rule, ray, triangle, plain).is_some()
}

/// The largest relative difference between the bounds on t that are worth keeping: 2^-24.
const CLOSE: f64 = f32::EPSILON as f64 / 2.0;

/// Bounds on t are kept only within these limits: 2^-120 and 2^120.
const LIMITS: [f64; 2] = [f64::from_bits((1023 - 120) << 52), f64::from_bits((1023 + 120) << 52)];

/// Returns the f32 values nearest to t on either side, or the same value twice if t is an f32.
#[inline(always)]
pub(crate) fn f32_bounds(t: f64) -> (f32, f32) {
    let near = t as f32;
    let (near64, t_lo, t_hi) = (f64::from(near), near.next_down(), near.next_up());
    // `near` is the f32 nearest to t. If it is above t, its lower neighbour is below t, and vice
    // versa.
    (if near64 > t { t_lo } else { near }, if near64 < t { t_hi } else { near })
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
    use super::{
        InFloat, PairDecision, Rule, crossing_from, decide_pair, f32_bounds, in_float, in_two_parts,
    };
    use crate::exact::test_numbers::random;
    use crate::exact::{Tier, t_from};
    use crate::{Mode, Ray, Ray64, Triangle, TriangleOf};

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

    #[test]
    fn f32_bounds_are_tight() {
        for t in [0.0, 1.0, 0.1, 1e-300, 1e300, -0.3, f64::from(f32::MAX) * (1.0 + 1e-9)] {
            let (lo, hi) = f32_bounds(t);
            assert!(f64::from(lo) <= t && t <= f64::from(hi), "{lo} {t} {hi}");
            assert!(lo == hi || lo.next_up() == hi);
        }
    }

    /// Returns how far t is from the middle of its bounds, as a fraction of half their width.
    /// Returns `None` if the ray misses or a bound is not finite.
    fn used(ray: &Ray, triangle: &Triangle) -> Option<f64> {
        let InFloat::Hit(_, [lo, hi]) = in_float(Rule::Closed, ray, triangle) else { return None };
        let t = t_from(Tier::Narrow, ray, triangle);
        assert!(lo <= t && (t <= hi || hi < 0.0), "{ray:?} {triangle:?}: {lo} {t} {hi}");
        if let PairDecision::Hit { t_lo, t_hi } = decide_pair(Rule::Closed, ray, triangle) {
            assert!(f64::from(t_lo) <= t && t <= f64::from(t_hi), "{ray:?} {triangle:?}");
            assert!(t_hi <= t_lo.next_up().next_up() || t_hi == f32::INFINITY);
        }
        (hi > lo && hi.is_finite()).then(|| (t - 0.5 * (lo + hi)).abs() / (0.5 * (hi - lo)))
    }

    /// Tests triangles of a few ulps, which are behind another triangle. Their hits must not hide it.
    #[test]
    fn tiny_triangles_do_not_hide_others() {
        let e = 12.0 * (-53.0_f32).exp2();
        let tiny = Triangle([[2.0 * e, -e, -e], [-e, 2.0 * e, -e], [-e, -e, 2.0 * e]]);
        let big = Triangle([[2.5, -3.5, -0.5], [-0.5, 2.5, -3.5], [-3.5, -0.5, 2.5]]);
        let ray = Ray::new([-1.0; 3], [1.0; 3]);
        assert_ne!(decide_pair(Rule::Closed, &ray, &tiny), PairDecision::Miss);
        for (triangles, first) in [([tiny, big], 1), ([big, tiny], 0)] {
            for mode in [Mode::exact(), Mode::once()] {
                let hit = mode.closest(&triangles, &ray).unwrap();
                assert_eq!((hit.triangle, hit.t), (first, 0.5));
            }
        }

        let ray = Ray64::new(
            [0.0; 3],
            [1.249_999_999_999_998_7, 1.500_000_000_000_001_6, 1.749_999_999_999_997_3],
        );
        let tiny = TriangleOf([
            [1.250_000_000_000_002_2, 1.500_000_000_000_006_2, 1.749_999_999_999_998_2],
            [1.249_999_999_999_988_5, 1.500_000_000_000_011_3, 1.749_999_999_999_998],
            [1.250_000_000_000_011_8, 1.499_999_999_999_990_5, 1.750_000_000_000_007_5],
        ]);
        // Whether f64 decides this pair depends on fused operations. It is a hit.
        assert_ne!(decide_pair(Rule::Closed, &ray, &tiny), PairDecision::Miss);
    }

    /// Tests rays that are nearly parallel to a triangle. f64 decides that they hit it, but D is so
    /// small, compared with its error, that the bounds on t are of no use.
    #[test]
    fn grazing_rays_have_no_bounds_on_t() {
        let (mut random, mut hits, mut unbounded) = (random(), 0, 0);
        for _ in 0..200_000 {
            let mut vec3 = || [0; 3].map(|_| random() as f32);
            let (a, b, c) = (vec3(), vec3(), vec3());
            let [p, q] = [random(), random()].map(|x| 0.25 * x as f32 + 0.25);
            let along = |k: usize| (b[k] - a[k]) + 0.3 * (c[k] - a[k]);
            let dir = [0, 1, 2].map(along);
            let origin = [0, 1, 2].map(|k| a[k] + p * (b[k] - a[k]) + q * (c[k] - a[k]) - dir[k]);
            let (ray, triangle) = (Ray::new(origin, dir), Triangle([a, b, c]));
            let decision = decide_pair(Rule::Closed, &ray, &triangle);
            if !matches!(decision, PairDecision::Hit { .. }) {
                continue;
            }
            hits += 1;
            if decision == PairDecision::HIT_ANYWHERE {
                unbounded += 1;
                let t = t_from(Tier::Narrow, &ray, &triangle);
                assert_eq!(Mode::exact().closest(&[triangle], &ray).unwrap().t, t, "{ray:?}");
            }
        }
        assert!(0 < unbounded && unbounded < hits, "{unbounded} of {hits} hits");
    }

    /// Tests random rays, then changes the worst of them step by step to come closer to the bounds.
    #[test]
    fn bounds_on_t_contain_t() {
        let (mut random, mut hits) = (random(), 0);
        let mut worst = (0.0, [0.0; 15]);
        for i in 0..400_000 {
            let numbers = if i % 100_000 < 10_000 {
                let mut point = || [0; 3].map(|_| random());
                let [a, b, c, o] = [point(), point(), point(), point()];
                let [p, q] = [0, 1].map(|_| 0.5 * random() + 0.25);
                let d = [0, 1, 2].map(|k| a[k] + p * (b[k] - a[k]) + q * (c[k] - a[k]) - o[k]);
                [a, b, c, o, d]
            } else {
                // Move each number by up to a small step of a random size.
                let step = (-20.0 * (random() + 0.5)).exp2();
                let [a, b, c, o, d] = *bytemuck::cast_ref::<[f64; 15], [[f64; 3]; 5]>(&worst.1);
                [a, b, c, o, d].map(|v| v.map(|x| x + step * random()))
            };
            let [a, b, c, o, d] = numbers.map(|v| v.map(|x| x as f32));
            let Some(used) = used(&Ray::new(o, d), &Triangle([a, b, c])) else { continue };
            hits += 1;
            if used > worst.0 {
                worst = (used, bytemuck::cast(numbers));
            }
        }
        assert!(hits > 100_000 && worst.0 > 0.15, "{hits} hits, {} of the bound", worst.0);
    }
}
