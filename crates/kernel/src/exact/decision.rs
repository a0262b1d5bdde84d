//! What f64 decides about rays and triangles before integers are needed: for one pair, or for up to
//! eight pairs side by side.

use super::float::{self, Decided, Signs};
use super::input::{is_plain, plain_lanes};
use super::tier::is_f64;
use super::wrapping;
use crate::packet::RayLanes;
use crate::simd::{Lanes, Level, Mask, Simd, Vec3, WithSimd};
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
pub(super) enum InFloat {
    /// The ray misses the triangle, or hits it outside its interval.
    Miss,
    /// The ray hits the triangle within its interval, on this side and with t between these bounds.
    Hit(Side, [f64; 2]),
    /// Only integers can decide. `plain` tells whether rounding is the only error of f64.
    Undecided { plain: bool },
}

/// Decides whether a ray hits a triangle within its interval, if f64 and its error bound suffice.
#[inline(always)]
pub(super) fn in_float<S: Scalar>(rule: Rule, ray: &RayOf<S>, triangle: &TriangleOf<S>) -> InFloat {
    if !is_plain(ray, triangle) {
        return InFloat::Undecided { plain: false };
    }
    if runs_along(ray, triangle) {
        return InFloat::Miss;
    }
    let corners = triangle.0.map(|corner| Vec3::<f64>::splat(corner.map(Into::into)));
    let (Decided { miss, closed, inside, leaves, .. }, t) =
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
        /// The edges on which the ray is known to meet the triangle: bit i stands for the edge
        /// opposite corner i + 1.
        edges: u8,
    },
    /// The error bound decides nothing.
    Undecided,
}

impl PairDecision {
    /// A hit whose t has no bounds.
    pub const HIT_ANYWHERE: Self = Self::Hit { t_lo: 0.0, t_hi: f32::INFINITY, edges: 0 };

    /// A hit whose t has these bounds, as computed by [`float::decide_with_t`].
    #[inline(always)]
    fn hit_within(lo: f64, hi: f64, edges: u8) -> Self {
        // If the error of D can exceed D, `hi` is infinite or negative. Bounds that are far apart
        // would not help, and f32 bounds near the limits of f32 may overflow or become 0.
        let are_close = hi >= lo && hi - lo <= lo * CLOSE;
        if !(are_close && lo >= LIMITS[0] && hi <= LIMITS[1]) {
            return Self::HIT_ANYWHERE;
        }
        Self::Hit { t_lo: f32_bounds(lo).0, t_hi: f32_bounds(hi).1, edges }
    }
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
        InFloat::Hit(_, [lo, hi]) => PairDecision::hit_within(lo, hi, 0),
    }
}

/// Up to eight rays and triangles in lanes.
///
/// ```
/// use intertri::internal::exact::{EightPairs, PairDecision, decide_pair};
/// use intertri::simd::Level;
/// use intertri::{Ray, Rule, Triangle};
/// let ray = Ray::new([0.25, 0.25, 0.0], [0.0, 0.0, 1.0]);
/// let at = |z| Triangle::new([0.0, 0.0, z], [1.0, 0.0, z], [0.0, 1.0, z]);
/// let mut pairs = EightPairs::new();
/// pairs.set(0, &ray, &at(5.0));
/// pairs.set(1, &ray, &at(-5.0));
/// let decisions = pairs.decide(Level::best(), Rule::Closed);
/// assert_eq!(decisions[0], decide_pair(Rule::Closed, &ray, &at(5.0)));
/// assert_eq!(decisions[1], PairDecision::Miss);
/// ```
#[derive(Clone, Copy, Debug)]
pub struct EightPairs<X> {
    /// The nine coordinates of the corners, the origin, the direction, `t_min`, and `t_max`.
    rows: [[X; 8]; 17],
}

impl<X: Scalar> Default for EightPairs<X> {
    fn default() -> Self {
        Self::new()
    }
}

impl<X: Scalar> EightPairs<X> {
    /// Creates a set of pairs in which every ray misses.
    #[inline(always)]
    pub fn new() -> Self {
        Self { rows: [[X::ZERO; 8]; 17] }
    }

    /// Stores a ray and a triangle in a lane.
    #[inline(always)]
    pub fn set(&mut self, lane: usize, ray: &RayOf<X>, triangle: &TriangleOf<X>) {
        for k in 0..3 {
            for corner in 0..3 {
                self.rows[3 * corner + k][lane] = triangle.0[corner][k];
            }
            self.rows[9 + k][lane] = ray.origin[k];
            self.rows[12 + k][lane] = ray.dir[k];
        }
        self.rows[15][lane] = ray.t_min;
        self.rows[16][lane] = ray.t_max;
    }

    /// Makes the same decisions as [`decide_pair`], for all lanes side by side.
    #[inline]
    pub fn decide(&self, level: Level, rule: Rule) -> [PairDecision; 8] {
        level.run(DecideEight { pairs: self, rule })
    }

    /// Returns the signs that integers find, given bounds on the errors of f64.
    #[inline(always)]
    fn wrapped_signs<S: Simd>(&self, bounds: [S::F64x8; 4]) -> Signs<<S::F64x8 as Lanes>::Mask> {
        let (mut rows, mut errors) = ([[0.0; 8]; 15], [[0.0; 8]; 4]);
        for (i, row) in rows.iter_mut().enumerate() {
            self.row::<S::F64x8>(i).store(row);
        }
        for (errors, bound) in errors.iter_mut().zip(bounds) {
            bound.store(errors);
        }
        let signs = wrapping::signs::<S>(&rows, &errors);
        let mut volumes = [[<S::F64x8 as Lanes>::Mask::from_bits(0); 3]; 4];
        for (masks, bits) in volumes.iter_mut().zip(signs) {
            for (mask, bits) in masks.iter_mut().zip(bits) {
                *mask = Mask::from_bits(bits);
            }
        }
        Signs { volumes }
    }

    /// Loads three rows.
    #[inline(always)]
    fn vec3<D: Lanes<Scalar = f64>>(&self, first: usize) -> Vec3<D> {
        Vec3 { x: self.row(first), y: self.row(first + 1), z: self.row(first + 2) }
    }

    /// Loads a row.
    #[inline(always)]
    fn row<D: Lanes<Scalar = f64>>(&self, i: usize) -> D {
        if const { is_f64::<X>() } {
            D::load(bytemuck::cast_slice(&self.rows[i]))
        } else {
            D::load_f32(bytemuck::cast_slice(&self.rows[i]))
        }
    }
}

struct DecideEight<'a, X> {
    pairs: &'a EightPairs<X>,
    rule: Rule,
}

impl<X: Scalar> WithSimd for DecideEight<'_, X> {
    type Output = [PairDecision; 8];

    #[inline(always)]
    fn run<S: Simd>(self) -> [PairDecision; 8] {
        let Self { pairs, rule } = self;
        let corners = [pairs.vec3::<S::F64x8>(0), pairs.vec3(3), pairs.vec3(6)];
        let (org, dir) = (pairs.vec3(9), pairs.vec3(12));
        let rays = RayLanes { org, dir, t_min: pairs.row(15), t_max: pairs.row(16) };
        // No verdict is valid for a lane that is not plain.
        let plain = plain_lanes(&pairs.rows);
        let (decided, [lo, hi]) = float::decide_refined(
            corners,
            &rays,
            #[inline(always)]
            |open, bounds| {
                if open & plain == 0 { None } else { Some(pairs.wrapped_signs::<S>(bounds)) }
            },
        );
        let miss = (decided.miss | run_along(dir, corners)).bits() & plain;
        let hit = if rule == Rule::Closed { decided.closed } else { decided.inside };
        let hit = hit.bits() & plain & !miss;
        let (mut t_lo, mut t_hi) = ([0.0; 8], [0.0; 8]);
        lo.store(&mut t_lo);
        hi.store(&mut t_hi);
        let [u, v, w] = decided.edges;
        let edges = [u.bits(), v.bits(), w.bits()];
        let mut decisions = [PairDecision::Undecided; 8];
        for (lane, decision) in decisions.iter_mut().enumerate() {
            if miss >> lane & 1 != 0 {
                *decision = PairDecision::Miss;
            } else if hit >> lane & 1 != 0 {
                let on = |i: usize| (edges[i] >> lane & 1) << i;
                let edges = (on(0) | on(1) | on(2)) as u8;
                *decision = PairDecision::hit_within(t_lo[lane], t_hi[lane], edges);
            }
        }
        decisions
    }
}

/// Like [`runs_along`], in lanes.
#[inline(always)]
fn run_along<D: Lanes<Scalar = f64>>(dir: Vec3<D>, [a, b, c]: [Vec3<D>; 3]) -> D::Mask {
    let zero = D::splat(0.0);
    let x = dir.x.abs().le(zero) & a.x.le(b.x) & b.x.le(c.x) & c.x.le(a.x);
    let y = dir.y.abs().le(zero) & a.y.le(b.y) & b.y.le(c.y) & c.y.le(a.y);
    let z = dir.z.abs().le(zero) & a.z.le(b.z) & b.z.le(c.z) & c.z.le(a.z);
    x | y | z
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

#[cfg(test)]
mod tests {
    use super::{EightPairs, InFloat, PairDecision, decide_pair, f32_bounds, in_float};
    use crate::exact::test_numbers::random;
    use crate::exact::tier::is_f64;
    use crate::exact::{Rule, Tier, attributes_from, crossing_from, t_from};
    use crate::simd::Level;
    use crate::{Mode, Ray, Ray64, RayOf, Scalar, Triangle, TriangleOf};

    /// Compares eight pairs side by side with integers of any width, at every level: rays toward
    /// edges, corners, and the interior, rays along axes, intervals, and numbers that are not plain.
    /// Coordinates are multiples of `step`, so that many rays meet edges exactly.
    fn eight_are_right<X: Scalar>(step: f64, odd: &[X]) {
        let (mut random, mut counts) = (random(), [0; 4]);
        for i in 0..20_000 {
            let (mut pairs, mut each) = (EightPairs::new(), Vec::new());
            for lane in 0..i % 9 {
                let mut vec3 =
                    || [0; 3].map(|_| X::nearest((16.0 * random() / step).round() * step));
                let corners = [vec3(), vec3(), vec3()];
                let (origin, mut dir) = (vec3(), vec3());
                let [x, y]: [f64; 2] = [random(), random()];
                let [p, q] = match lane % 4 {
                    0 => [0.5, 0.0],
                    1 => [1.0, 0.0],
                    2 => [x + 0.5, 0.0],
                    _ => [0.5 * x, 0.5 * y],
                };
                for k in 0..3 {
                    let [a, b, c, o] = [corners[0][k], corners[1][k], corners[2][k], origin[k]];
                    let [a, b, c, o]: [f64; 4] = [a.into(), b.into(), c.into(), o.into()];
                    dir[k] = X::nearest(a + p * (b - a) + q * (c - a) - o);
                }
                let mut ray = RayOf { origin, t_min: X::ZERO, dir, t_max: X::INFINITY };
                let mut triangle = TriangleOf(corners);
                match (i + lane) % 8 {
                    0 => ray.t_max = X::ONE,
                    1 => ray.t_min = X::ONE,
                    2 => {
                        ray.dir[i % 3] = X::ZERO;
                        (0..3).for_each(|corner| triangle.0[corner][i % 3] = ray.origin[i % 3]);
                    }
                    3 => triangle.0[i % 3][lane % 3] = odd[i % odd.len()],
                    4 => ray.dir[lane % 3] = odd[i % odd.len()],
                    _ => {}
                }
                pairs.set(lane, &ray, &triangle);
                each.push((ray, triangle));
            }
            for rule in [Rule::Closed, Rule::Once] {
                let truth: Vec<bool> = (each.iter())
                    .map(|(ray, triangle)| {
                        crossing_from(Tier::Narrow, rule, ray, triangle).is_some()
                    })
                    .collect();
                for level in Level::all() {
                    let decisions = pairs.decide(level, rule);
                    for (lane, (ray, triangle)) in each.iter().enumerate() {
                        let hit = match decisions[lane] {
                            PairDecision::Undecided => {
                                counts[0] += 1;
                                continue;
                            }
                            PairDecision::Miss => false,
                            PairDecision::Hit { t_lo, t_hi, edges } => {
                                let t = t_from(Tier::Narrow, ray, triangle);
                                assert!(f64::from(t_lo) <= t && t <= f64::from(t_hi), "{ray:?}");
                                counts[2] += u32::from(edges != 0);
                                check_edges(edges, ray, triangle);
                                true
                            }
                        };
                        counts[if hit { 1 } else { 3 }] += 1;
                        assert_eq!(hit, truth[lane], "{rule:?} {ray:?} {triangle:?}");
                    }
                }
            }
        }
        // f64 numbers with many digits have volumes with more than 64 bits, which stay undecided.
        let [undecided, hits, on_edges, misses] = counts;
        assert!(undecided > 3000 && hits > 3000 && misses > 3000, "{counts:?}");
        assert!(on_edges > 3000 || is_f64::<X>() && step == 1e-7, "{counts:?}");
    }

    /// The weights of the corners opposite the edges must be 0.
    fn check_edges<X: Scalar>(edges: u8, ray: &RayOf<X>, triangle: &TriangleOf<X>) {
        let (_, u, v) = attributes_from(Tier::Narrow, ray, triangle);
        assert!(edges >> 1 & 1 == 0 || u == 0.0, "{ray:?} {triangle:?}");
        assert!(edges >> 2 & 1 == 0 || v == 0.0, "{ray:?} {triangle:?}");
        // Both weights are rounded, so their sum need not be 1 exactly.
        assert!(edges & 1 == 0 || (u + v - 1.0).abs() < 1e-15, "{ray:?} {triangle:?}");
    }

    #[test]
    fn eight_pairs_side_by_side_are_right() {
        for step in [1.0, 0.015_625, 1e-7] {
            eight_are_right(step, &[1e-45_f32, -1e-40, f32::NAN, f32::INFINITY, -0.0]);
            eight_are_right(step, &[1e-310_f64, 1e-250, 1e200, f64::NAN, f64::NEG_INFINITY, -0.0]);
        }
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
