//! Decides up to eight pairs of a ray and a triangle side by side: in f64, and then, where the
//! error bound does not suffice, in integers that wrap: of 64 bits and, with AVX-512, of 128.

use super::decision::{PairDecision, Rule, close_bounds};
use super::float;
use super::input::plain_lanes;
use super::tier::is_f64;
use super::wrapping::{in_64_bits, in_lanes};
use crate::packet::RayLanes;
use crate::simd::{Ints, Lanes, Level, Mask, Simd, Vec3, WithSimd};
use crate::{RayOf, Scalar, TriangleOf};

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
/// assert_eq!(decisions[0], Some(decide_pair(Rule::Closed, &ray, &at(5.0))));
/// assert_eq!(decisions[1], Some(PairDecision::Miss));
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

    /// Decides lanes side by side, like [`decide_pair`](super::decide_pair). Few pairs stay undecided:
    /// those of very large or small numbers, and those of numbers with many digits.
    #[inline]
    pub fn decide(&self, level: Level, rule: Rule) -> [Option<PairDecision>; 8] {
        let rows = if const { is_f64::<X>() } {
            Rows::F64(bytemuck::cast_ref(&self.rows))
        } else {
            Rows::F32(bytemuck::cast_ref(&self.rows))
        };
        decide(level, rule, rows)
    }
}

impl EightPairs<f32> {
    /// Returns the triangles and the rays in f64 lanes.
    #[inline(always)]
    pub(crate) fn lanes_in<S: Simd>(&self) -> ([Vec3<S::F64x8>; 3], RayLanes<S::F64x8>) {
        let row = |i: usize| S::F64x8::load_f32(&self.rows[i]);
        let vec3 = |first: usize| Vec3 { x: row(first), y: row(first + 1), z: row(first + 2) };
        let rays = RayLanes { org: vec3(9), dir: vec3(12), t_min: row(15), t_max: row(16) };
        ([vec3(0), vec3(3), vec3(6)], rays)
    }
}

/// The rows of [`EightPairs`].
#[derive(Clone, Copy)]
enum Rows<'a> {
    F32(&'a [[f32; 8]; 17]),
    F64(&'a [[f64; 8]; 17]),
}

#[inline(never)]
fn decide(level: Level, rule: Rule, rows: Rows<'_>) -> [Option<PairDecision>; 8] {
    level.run(DecideEight { rows, rule })
}

struct DecideEight<'a> {
    rows: Rows<'a>,
    rule: Rule,
}

impl WithSimd for DecideEight<'_> {
    type Output = [Option<PairDecision>; 8];

    #[inline(always)]
    fn run<S: Simd>(self) -> [Option<PairDecision>; 8] {
        let Self { rows, rule } = self;
        let is_f32 = matches!(rows, Rows::F32(_));
        let mut widened = [[0.0; 8]; 17];
        // No verdict is valid for a lane that is not plain.
        let (rows, plain) = match rows {
            Rows::F64(rows) => (rows, plain_lanes(rows)),
            Rows::F32(rows) => {
                for (to, row) in widened.iter_mut().zip(rows) {
                    S::F64x8::load_f32(row).store(to);
                }
                (&widened, plain_lanes(rows))
            }
        };
        let row = |i: usize| S::F64x8::load(&rows[i]);
        let vec3 = |first: usize| Vec3 { x: row(first), y: row(first + 1), z: row(first + 2) };
        let corners = [vec3(0), vec3(3), vec3(6)];
        let (org, dir) = (vec3(9), vec3(12));
        let rays = RayLanes { org, dir, t_min: row(15), t_max: row(16) };
        let along = float::runs_along(dir, corners);
        let (decided, [lo, hi]) = float::decide_refined(
            corners,
            &rays,
            #[inline(always)]
            |decided, known, bounds| {
                let settled = decided.miss | along | decided.hits(rule);
                let open = (!settled).bits() & plain;
                if open == 0 {
                    return None;
                }
                let narrow = in_64_bits::<S>(rows);
                let signs = narrow.add_signs((rule, open), corners, &rays, known, bounds);
                // For f32, no measured model needs more than 64 bits, and in adversarial scenes this
                // step costs more than it gains.
                if S::WideInts::BITS == S::I64x8::BITS || is_f32 {
                    return Some(signs);
                }
                let decided = signs.decide();
                let open = open & !(decided.miss | decided.hits(rule)).bits();
                if open == 0 {
                    return Some(signs);
                }
                let wide = in_lanes::<S::F64x8, S::WideInts>(rows, narrow.units);
                Some(wide.add_signs((rule, open), corners, &rays, &signs, bounds))
            },
        );
        let miss = (decided.miss | along).bits() & plain;
        let hit = decided.hits(rule).bits() & plain & !miss;
        let [t_lo, t_hi] = close_bounds(lo, hi);
        let [u, v, w] = decided.edges;
        let edges = [u.bits(), v.bits(), w.bits()];
        let mut decisions = [None; 8];
        for (lane, decision) in decisions.iter_mut().enumerate() {
            if miss >> lane & 1 != 0 {
                *decision = Some(PairDecision::Miss);
            } else if hit >> lane & 1 != 0 {
                let on = |i: usize| (edges[i] >> lane & 1) << i;
                let edges = (on(0) | on(1) | on(2)) as u8;
                let (t_lo, t_hi) = (t_lo[lane], t_hi[lane]);
                *decision = Some(PairDecision::Hit { t_lo, t_hi, edges });
            }
        }
        decisions
    }
}

#[cfg(test)]
mod tests {
    use super::{EightPairs, PairDecision, Rule};
    use crate::exact::decision::{InFloat, in_float};
    use crate::exact::test_numbers::random;
    use crate::exact::tier::is_f64;
    use crate::exact::{Tier, attributes_from, crossing_from, t_from};
    use crate::simd::Level;
    use crate::{RayOf, Scalar, TriangleOf};

    /// Compares eight pairs side by side with integers of any width, at every level: rays toward
    /// edges, corners, and the interior, rays along axes, intervals, and numbers that are not plain.
    /// Coordinates are multiples of `step`, so that many rays meet edges exactly.
    fn eight_are_right<X: Scalar>(step: f64, odd: &[X]) {
        let (mut random, mut counts) = (random(), [0; 6]);
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
                vary((i, lane), (&mut ray, &mut triangle), odd[i % odd.len()]);
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
                            None => {
                                counts[0] += 1;
                                continue;
                            }
                            Some(PairDecision::Miss) => false,
                            Some(PairDecision::HitAt(_)) => {
                                unreachable!("only document A has this t")
                            }
                            Some(PairDecision::Hit { t_lo, t_hi, edges }) => {
                                assert!(truth[lane], "{rule:?} {ray:?} {triangle:?}");
                                let t = t_from(Tier::Narrow, ray, triangle);
                                assert!(f64::from(t_lo) <= t && t <= f64::from(t_hi), "{ray:?}");
                                counts[2] += u32::from(edges != 0);
                                counts[5] += u32::from(t == ray.t_min.into());
                                check_edges(edges, ray, triangle);
                                true
                            }
                        };
                        counts[if hit { 1 } else { 3 }] += 1;
                        assert_eq!(hit, truth[lane], "{rule:?} {ray:?} {triangle:?}");
                        // The ray meets an edge that another triangle may own.
                        let by_f64 =
                            !matches!(in_float(rule, ray, triangle), InFloat::Undecided { .. });
                        counts[4] += u32::from(rule == Rule::Once && !by_f64 && !hit);
                    }
                }
            }
        }
        // f64 numbers with many digits have volumes with more than 64 bits, which stay undecided.
        let [undecided, hits, on_edges, misses, not_owned, starting] = counts;
        // Each level decides the same pairs.
        let some = 1000 * Level::all().count() as u32;
        assert!(undecided > some && hits > some && misses > some, "{counts:?}");
        assert!(starting > some / 4 || step == 1e-7, "{counts:?}");
        assert!(on_edges > some && not_owned > some || is_f64::<X>() && step == 1e-7, "{counts:?}");
    }

    /// Changes the interval, a number, or the direction of some pairs.
    fn vary<X: Scalar>(
        (i, lane): (usize, usize),
        (ray, triangle): (&mut RayOf<X>, &mut TriangleOf<X>),
        odd: X,
    ) {
        match (i + lane) % 8 {
            0 => ray.t_max = X::ONE,
            1 => ray.t_min = X::ONE,
            2 => {
                ray.dir[i % 3] = X::ZERO;
                (0..3).for_each(|corner| triangle.0[corner][i % 3] = ray.origin[i % 3]);
            }
            3 => triangle.0[i % 3][lane % 3] = odd,
            4 => ray.dir[lane % 3] = odd,
            5 => ray.dir = [X::nearest([0.0, -0.0][lane % 2]); 3],
            6 => ray.t_max = X::nearest([-1.0, 0.0, -0.0, f64::NEG_INFINITY][i % 4]),
            _ => {}
        }
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
}
