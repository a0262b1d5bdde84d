//! What is decided about a ray and a triangle, and what f64 can decide of it.

use super::float::{self, Decided};
use super::input::is_plain;
use crate::packet::RayLanes;
use crate::simd::{Lanes, Mask, Vec3};
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

impl<M: Mask> Decided<M> {
    /// Returns the lanes that are certainly hits under a rule.
    #[inline(always)]
    pub(super) fn hits(&self, rule: Rule) -> M {
        if rule == Rule::Closed { self.closed } else { self.inside }
    }
}

/// What f64 can say about a ray and a triangle.
pub(super) enum InFloat {
    /// The ray misses the triangle, or hits it outside its interval.
    Miss,
    /// The ray hits the triangle within its interval, on this side, with t between these bounds, and
    /// certainly on these edges ([`PairDecision::Hit`]).
    Hit(Side, [f64; 2], u8),
    /// Only integers can decide. If rounding is the only error of f64, `t` has bounds on t, which hold
    /// if the ray hits the triangle.
    Undecided { t: Option<[f64; 2]> },
}

/// Decides whether a ray hits a triangle within its interval, if f64 and its error bound suffice.
#[inline(always)]
pub(super) fn in_float<S: Scalar>(rule: Rule, ray: &RayOf<S>, triangle: &TriangleOf<S>) -> InFloat {
    if !is_plain(ray, triangle) {
        return InFloat::Undecided { t: None };
    }
    let corners = triangle.0.map(|corner| Vec3::<f64>::splat(corner.map(Into::into)));
    if float::runs_along(Vec3::splat(ray.dir.map(Into::into)), corners) {
        return InFloat::Miss;
    }
    let (Decided { miss, closed, inside, leaves, edges: [u, v, w] }, t) =
        float::decide_with_t(corners, &RayLanes::of_ray(ray));
    if miss {
        return InFloat::Miss;
    }
    // On an edge, the closed rule accepts the hit. The *once* rule would need the signs of normals,
    // which are not computed for a single pair.
    if inside || rule == Rule::Closed && closed {
        let edges = u8::from(u) | u8::from(v) << 1 | u8::from(w) << 2;
        return InFloat::Hit(if leaves { Side::Leaves } else { Side::Enters }, t, edges);
    }
    InFloat::Undecided { t: Some(t) }
}

/// What is decided about a ray and a triangle.
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
        /// The edges on which the ray is known to meet the triangle: bit i stands for the edge
        /// opposite corner i + 1.
        edges: u8,
    },
    /// The ray hits the triangle within its interval, at this t.
    HitAt(f64),
}

impl PairDecision {
    /// A hit whose t has no bounds.
    pub const HIT_ANYWHERE: Self = Self::Hit { t_lo: 0.0, t_hi: f32::INFINITY, edges: 0 };

    /// A hit whose t has these bounds, as computed by [`float::decide_with_t`].
    #[inline(always)]
    pub(super) fn hit_within(lo: f64, hi: f64, edges: u8) -> Self {
        let [[t_lo, ..], [t_hi, ..]] = close_bounds(lo, hi);
        Self::Hit { t_lo, t_hi, edges }
    }
}

/// Returns f32 bounds on t in each lane, given those computed by [`float::decide_with_t`]: the bounds
/// rounded outward if they are close to each other, otherwise 0 and infinity.
#[inline(always)]
pub(super) fn close_bounds<D: Lanes<Scalar = f64>>(lo: D, hi: D) -> [[f32; 8]; 2] {
    // If the error of D can exceed D, `hi` is infinite or negative. Bounds that are far apart
    // would not help, and f32 bounds near the limits of f32 may overflow or become 0.
    let within = lo.ge(D::splat(LIMITS[0])) & hi.le(D::splat(LIMITS[1]));
    let close = hi.ge(lo) & (hi - lo).le(lo * D::splat(CLOSE)) & within;
    let lo = D::select(close, lo, D::splat(0.0));
    let hi = D::select(close, hi, D::splat(f64::INFINITY));
    let [mut t_lo, mut t_hi] = [[0.0; 8]; 2];
    lo.store_f32(&mut t_lo);
    hi.store_f32(&mut t_hi);
    // If the nearest f32 is on the wrong side, the bound is its neighbour, whose bits differ by 1.
    let (above, below) = (D::load_f32(&t_lo).gt(lo).bits(), D::load_f32(&t_hi).lt(hi).bits());
    for lane in 0..D::N {
        t_lo[lane] = f32::from_bits(t_lo[lane].to_bits() - (above >> lane & 1));
        t_hi[lane] = f32::from_bits(t_hi[lane].to_bits() + (below >> lane & 1));
    }
    [t_lo, t_hi]
}

/// The largest relative difference between the bounds on t that are worth keeping: 2^-24.
const CLOSE: f64 = f32::EPSILON as f64 / 2.0;

/// Bounds on t are kept only within these limits: 2^-120 and 2^120.
pub(super) const LIMITS: [f64; 2] =
    [f64::from_bits((1023 - 120) << 52), f64::from_bits((1023 + 120) << 52)];

/// Returns the f32 values nearest to t on either side, or the same value twice if t is an f32.
#[inline(always)]
pub(crate) fn f32_bounds(t: f64) -> (f32, f32) {
    let near = t as f32;
    let (near64, t_lo, t_hi) = (f64::from(near), near.next_down(), near.next_up());
    // `near` is the f32 nearest to t. If it is above t, its lower neighbour is below t, and vice
    // versa.
    (if near64 > t { t_lo } else { near }, if near64 < t { t_hi } else { near })
}

#[cfg(test)]
mod tests {
    use super::{InFloat, LIMITS, PairDecision, Rule, close_bounds, f32_bounds, in_float};
    use crate::exact::test_numbers::random;
    use crate::exact::{Tier, decide_pair, t_from};
    use crate::simd::{Lanes, Level, Simd, WithSimd};
    use crate::{Mode, Ray, Ray64, Triangle, TriangleOf};

    #[test]
    fn f32_bounds_are_tight() {
        for t in [0.0, 1.0, 0.1, 1e-300, 1e300, -0.3, f64::from(f32::MAX) * (1.0 + 1e-9)] {
            let (lo, hi) = f32_bounds(t);
            assert!(f64::from(lo) <= t && t <= f64::from(hi), "{lo} {t} {hi}");
            assert!(lo == hi || lo.next_up() == hi);
        }
    }

    /// Rounds eight pairs of bounds.
    struct Rounded([[f64; 8]; 2]);

    impl WithSimd for Rounded {
        type Output = [[f32; 8]; 2];

        #[inline(always)]
        fn run<S: Simd>(self) -> [[f32; 8]; 2] {
            let [lo, hi] = &self.0;
            close_bounds(S::F64x8::load(lo), S::F64x8::load(hi))
        }
    }

    #[test]
    fn close_bounds_are_rounded_outward_and_no_farther() {
        let [least, most] = LIMITS;
        let (one, next) = (1.0_f64, f64::from(1.0_f32.next_up()));
        let close = [one, one.next_up(), one.next_down(), next, 0.1, 1e-30, least, most];
        let far =
            [f64::NAN, f64::INFINITY, 0.0, -1.0, most.next_up(), least.next_down(), 1.0, 1e300];
        for level in Level::all() {
            for hi in [close, close.map(f64::next_up)] {
                let [t_lo, t_hi] = level.run(Rounded([close, hi]));
                for lane in 0..7 {
                    assert_eq!(t_lo[lane], f32_bounds(close[lane]).0, "{}", level.name());
                    assert_eq!(t_hi[lane], f32_bounds(hi[lane]).1, "{}", level.name());
                }
            }
            // Beyond the limits, or far apart.
            let mut hi = far;
            hi[6] = 1.0 + 1e-6;
            let [t_lo, t_hi] = level.run(Rounded([far, hi]));
            assert_eq!((t_lo, t_hi), ([0.0; 8], [f32::INFINITY; 8]), "{}", level.name());
            let [t_lo, t_hi] = level.run(Rounded([[1.0; 8], [1.0_f64.next_down(); 8]]));
            assert_eq!((t_lo, t_hi), ([0.0; 8], [f32::INFINITY; 8]), "{}", level.name());
        }
    }

    /// Returns how far t is from the middle of its bounds, as a fraction of half their width.
    /// Returns `None` if the ray misses or a bound is not finite.
    fn used(ray: &Ray, triangle: &Triangle) -> Option<f64> {
        let InFloat::Hit(_, [lo, hi], _) = in_float(Rule::Closed, ray, triangle) else {
            return None;
        };
        let t = t_from(Tier::Narrow, ray, triangle);
        assert!(lo <= t && (t <= hi || hi < 0.0), "{ray:?} {triangle:?}: {lo} {t} {hi}");
        if let PairDecision::Hit { t_lo, t_hi, .. } = decide_pair(Rule::Closed, ray, triangle) {
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
        // If the error of D exceeds D, the upper bound is negative.
        assert_eq!(PairDecision::hit_within(1.0, -5.0, 0), PairDecision::HIT_ANYWHERE);
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
