//! Compares closest-point queries with a different method, computed in rational arithmetic.

pub(crate) mod truth;

use dashu_ratio::RBig;
use intertri::internal::exact::{Tier, closer_from, closest, has_area, squares};
use intertri::simd::Vec3;
use intertri::{Scalar, Triangle};
use intertri_lab::rng::Rng;
use intertri_trace::{Bvh, ClosestPoint};

use truth::{is_rounded, is_within_one_ulp, truth};

/// A generator of coordinates of many kinds: on small grids, arbitrary, close together, over the
/// whole range of f32, or subnormal.
struct Numbers {
    rng: Rng,
    kind: usize,
}

impl Numbers {
    fn unit(&mut self) -> f64 {
        self.rng.unit()
    }

    fn number(&mut self) -> f32 {
        let unit = self.unit() * 2.0 - 1.0;
        match self.kind {
            0 => (unit * 2.5).round() as f32,
            1 => unit as f32,
            2 => (1000.0 + (unit * 40.0).round() / 8192.0) as f32,
            3 => (unit * 10.0_f64.powf(self.unit() * 60.0 - 30.0)) as f32,
            4 => f32::from_bits((self.unit() * 40.0) as u32),
            5 => (unit * 3e38) as f32,
            _ => (unit * 4.0).round() as f32 * f32::from_bits(1 << 20),
        }
    }

    fn point(&mut self) -> [f32; 3] {
        [self.number(), self.number(), self.number()]
    }

    /// Generates a triangle, which is sometimes a needle or degenerate.
    fn triangle(&mut self) -> Triangle {
        let mut t = Triangle([self.point(), self.point(), self.point()]);
        if self.unit() < 0.25 {
            flatten(&mut t.0, self.unit());
        } else if self.unit() < 0.2 {
            let share = self.unit() as f32;
            let at = |k: usize| t.0[0][k] * (1.0 - share) + t.0[1][k] * share;
            t.0[2] = [at(0), at(1), at(2)];
            let k = (self.unit() * 3.0) as usize;
            t.0[2][k] = if self.unit() < 0.5 { t.0[2][k].next_up() } else { t.0[2][k] };
        }
        t
    }

    /// Generates a point at an arbitrary position, at a corner, on an edge, near a face, or beyond
    /// a corner.
    fn point_near(&mut self, t: &Triangle) -> [f32; 3] {
        let [a, b, c] = t.0;
        let (u, v) = (self.unit() as f32, self.unit() as f32);
        match (self.unit() * 6.0) as usize {
            0 => a,
            1 => [0, 1, 2].map(|k| a[k] * (1.0 - u) + b[k] * u),
            2 => [0, 1, 2].map(|k| a[k] * (1.0 - u - v) + b[k] * u + c[k] * v),
            3 => [0, 1, 2].map(|k| b[k] * 2.0 - a[k]),
            _ => self.point(),
        }
    }
}

/// Makes a triangle degenerate: two or three corners are equal, or the three corners are collinear
/// in any order. They are exactly collinear if the coordinates have enough spare bits.
pub(crate) fn flatten<S: Scalar>(corners: &mut [[S; 3]; 3], unit: f64) {
    let which = (unit * 12.0) as usize;
    let [i, j] = [[0, 1], [1, 2], [2, 0]][which % 3];
    match which / 3 {
        0 => corners[i] = corners[j],
        1 => *corners = [corners[which % 3]; 3],
        // The third corner is at the midpoint of the other two, or beyond one of them by the
        // distance between them.
        shape => {
            let (a, b, k) = (corners[i], corners[j], 3 - i - j);
            let [a, b] = [a, b].map(|corner| corner.map(Into::<f64>::into));
            let at =
                |x: usize| if shape == 2 { 0.5 * a[x] + 0.5 * b[x] } else { 2.0 * b[x] - a[x] };
            corners[k] = [0, 1, 2].map(|x| S::nearest(at(x)));
        }
    }
}

const KINDS: usize = 7;

#[test]
fn every_tier_is_right_of_every_pair() {
    let (mut pairs, mut ties, mut flat) = (0, 0, 0);
    for i in 0..14_000 {
        let mut numbers = Numbers { rng: Rng::new(i), kind: i as usize % KINDS };
        let (one, other) = (numbers.triangle(), numbers.triangle());
        let mut other = other;
        if i % 3 == 0 {
            // Let the two triangles share an edge or a corner.
            other.0[0] = one.0[1];
            other.0[1] = if i % 2 == 0 { one.0[0] } else { other.0[1] };
        }
        let point = numbers.point_near(&one);
        let finite = |t: &Triangle| t.0.as_flattened().iter().all(|x| x.is_finite());
        if !point.iter().all(|x| x.is_finite()) || !finite(&one) || !finite(&other) {
            continue;
        }
        let (first, second) = (truth(point, &one), truth(point, &other));
        pairs += 1;
        flat += usize::from(!has_area(&one));
        ties += usize::from(first.0 == second.0);
        for &tier in Tier::all::<f32>() {
            let order = closer_from(tier, point, &one, &other);
            assert_eq!(order, first.0.cmp(&second.0), "{tier:?}: {point:?}, {one:?}, {other:?}");
            let found = closest(tier, point, &one);
            assert!(
                is_within_one_ulp(found.distance, &first.0),
                "{tier:?}: {point:?}, {one:?}: {found:?}"
            );
            for (weight, exact) in found.weights.iter().zip(&first.1) {
                assert!(is_rounded(*weight, exact), "{tier:?}: {point:?}, {one:?}: {found:?}");
            }
        }

        // Check the bounds computed in SIMD lanes.
        let vec3 = |p: [f32; 3]| Vec3::<f64>::splat(p.map(f64::from));
        let bounds = squares(one.0.map(vec3), vec3(point));
        let bound = |x: f64| RBig::try_from(x).unwrap();
        assert!(
            bound(bounds.least) <= first.0,
            "{point:?}, {one:?}: {bounds:?}",
            bounds = bounds.least
        );
        assert!(
            bounds.most.is_infinite() || bound(bounds.most) >= first.0,
            "{point:?}, {one:?}: {}",
            bounds.most
        );
    }
    let counts = format!("{pairs} pairs, {ties} ties, {flat} with zero area");
    assert!(pairs > 9000 && ties > 1000 && flat > 1500, "{counts}");
}

#[test]
fn bounds_are_sharp_where_numbers_are_sane() {
    let mut numbers = Numbers { rng: Rng::new(7), kind: 1 };
    let (mut sharp, mut all) = (0, 0);
    for _ in 0..2000 {
        let (t, point) = (numbers.triangle(), numbers.point());
        let vec3 = |p: [f32; 3]| Vec3::<f64>::splat(p.map(f64::from));
        let bounds = squares(t.0.map(vec3), vec3(point));
        all += 1;
        sharp += usize::from(bounds.most - bounds.least <= bounds.most * 1e-8);
    }
    assert!(sharp * 100 > all * 95, "{sharp} of {all}");
}

#[test]
fn meshes_are_asked_as_a_plain_loop() {
    for kind in 0..KINDS {
        let mut numbers = Numbers { rng: Rng::new(100 + kind as u64), kind };
        let triangles: Vec<Triangle> = (0..60).map(|_| numbers.triangle()).collect();
        let points: Vec<[f32; 3]> = (0..60)
            .map(|i| numbers.point_near(&triangles[i % 60]))
            .filter(|p| p.iter().all(|x| x.is_finite()))
            .collect();
        let bvh = Bvh::new(&triangles).unwrap();
        let mut answers = vec![ClosestPoint::NONE; points.len()];
        bvh.closest_point_batch_into(&points, f64::INFINITY, &mut answers);
        for (&point, answer) in points.iter().zip(&answers) {
            let finite = |t: &Triangle| t.0.as_flattened().iter().all(|x| x.is_finite());
            let there = (0..triangles.len()).filter(|&i| finite(&triangles[i]));
            let best = there.map(|i| (truth(point, &triangles[i]).0, i)).min();
            let found = answer.some().map(|closest| closest.triangle as usize);
            assert_eq!(found, best.as_ref().map(|best| best.1), "{point:?}");
            if let Some((square, _)) = best {
                assert!(is_within_one_ulp(answer.distance, &square));
            }
        }
    }
}
