//! Tests the oracle's implementations against each other, against integer arithmetic, and against
//! the scalar f64 reference.

use std::cmp::Ordering;

use intertri::{Ray, Triangle};
use intertri_reference::{Ray as F64Ray, Scene as F64Scene};

use super::adaptive::exact_difference;
use super::{LinePosition, OracleAnswer, Rational, answer, exact_t, rational};
use super::{t_error, t_error_ulps, t_error_ulps_f32};
use crate::families::{Case, FAMILIES, adversarial, find};
use crate::rng::Rng;

/// Converts an answer to the corner numbering of the triangle with permuted corners.
fn renamed(answer: OracleAnswer, order: [usize; 3]) -> OracleAnswer {
    let to = |k: u8| order.iter().position(|&old| old == usize::from(k)).map_or(k, |k| k as u8);
    let place = match answer.place {
        LinePosition::Vertex(k) => LinePosition::Vertex(to(k)),
        LinePosition::Edge(k) => LinePosition::Edge(to(k)),
        place => place,
    };
    OracleAnswer { place, ..answer }
}

#[test]
fn two_routes_agree_on_every_family() {
    // Count the inputs whose differences are exact in f64, the other inputs, and each position.
    let (mut adaptive, mut fallback) = (0, 0);
    let mut places = [0_u32; 8];
    for family in FAMILIES {
        let mut rng = Rng::new(31);
        for _ in 0..400 {
            let Case { triangle, ray, .. } = family.case(&mut rng);
            let got = answer(&triangle, &ray);
            assert_eq!(
                got,
                rational::answer(&triangle, &ray),
                "{}: {ray:?} {triangle:?}",
                family.name
            );
            let fits = triangle.0.iter().all(|&p| exact_difference(p, ray.origin).is_some());
            *if fits { &mut adaptive } else { &mut fallback } += 1;
            let place = match got.place {
                LinePosition::NotFinite => 0,
                LinePosition::Degenerate => 1,
                LinePosition::Coplanar => 2,
                LinePosition::Parallel => 3,
                LinePosition::Outside => 4,
                LinePosition::Vertex(_) => 5,
                LinePosition::Edge(_) => 6,
                LinePosition::Inside => 7,
            };
            places[place] += 1;
        }
    }
    assert!(adaptive > 5000 && fallback > 500, "{adaptive} {fallback}");
    assert!(places.iter().all(|&n| n > 15), "{places:?}");
}

#[test]
fn the_names_of_the_corners_do_not_matter() {
    for family in FAMILIES {
        let mut rng = Rng::new(32);
        for _ in 0..200 {
            let Case { triangle, ray, .. } = family.case(&mut rng);
            let first = answer(&triangle, &ray);
            for order in [[1, 2, 0], [2, 0, 1], [0, 2, 1], [1, 0, 2], [2, 1, 0]] {
                let other = Triangle(order.map(|k| triangle.0[k]));
                assert_eq!(answer(&other, &ray), renamed(first, order), "{}", family.name);
            }
        }
    }
}

#[test]
fn a_third_route_in_integers_agrees_on_the_grids() {
    type Int = [i128; 3];
    let det = |a: Int, b: Int, c: Int| {
        a[0] * (b[1] * c[2] - b[2] * c[1])
            + a[1] * (b[2] * c[0] - b[0] * c[2])
            + a[2] * (b[0] * c[1] - b[1] * c[0])
    };
    for (name, grid) in
        [("icosphere-exact", 262_144.0), ("torus-exact", 262_144.0), ("cube-exact", 1.0)]
    {
        let mut rng = Rng::new(33);
        for _ in 0..3000 {
            let Case { triangle, ray, .. } = find(name).unwrap().case(&mut rng);
            let whole = |p: [f32; 3]| p.map(|x| i128::from((f64::from(x) * grid) as i64));
            let (o, d) = (whole(ray.origin), whole(ray.dir));
            let [a, b, c] = triangle.0.map(whole).map(|p| [p[0] - o[0], p[1] - o[1], p[2] - o[2]]);
            let (u, v, w) = (det(d, b, c), det(d, c, a), det(d, a, b));
            let (num, den) = (det(a, b, c), u + v + w);
            let got = answer(&triangle, &ray);
            if den == 0 {
                assert!(
                    got.place <= LinePosition::Parallel && got.place >= LinePosition::Degenerate
                );
                assert_eq!(exact_t(&triangle, &ray), None);
                continue;
            }
            assert_eq!(got.t, (num * den.signum()).cmp(&0));
            let zeros = [u, v, w].map(|x| usize::from(x == 0)).iter().sum::<usize>();
            let mixed = u.min(v).min(w) < 0 && u.max(v).max(w) > 0;
            let agrees = match got.place {
                LinePosition::Outside => mixed,
                LinePosition::Inside => !mixed && zeros == 0,
                LinePosition::Edge(k) => !mixed && zeros == 1 && [u, v, w][usize::from(k)] == 0,
                LinePosition::Vertex(k) => !mixed && zeros == 2 && [u, v, w][usize::from(k)] != 0,
                _ => false,
            };
            assert!(agrees, "{got:?} {u} {v} {w}");
            let exact = Rational::from(num) / Rational::from(den);
            assert_eq!(exact_t(&triangle, &ray), Some(exact));
        }
    }
}

/// An f64 value with an error bound, for an approximate third computation of `t`.
#[derive(Clone, Copy)]
struct Near(f64, f64);

impl Near {
    const HALF_STEP: f64 = f64::EPSILON / 2.0;

    fn sub(self, b: Self) -> Self {
        let x = self.0 - b.0;
        Self(x, self.1 + b.1 + x.abs() * 2.0 * Self::HALF_STEP)
    }

    fn mul(self, b: Self) -> Self {
        let x = self.0 * b.0;
        let spread = self.0.abs() * b.1 + self.1 * b.0.abs() + self.1 * b.1;
        Self(x, spread + x.abs() * 2.0 * Self::HALF_STEP)
    }

    fn add(self, b: Self) -> Self {
        self.sub(Self(-b.0, b.1))
    }
}

#[test]
fn t_lies_in_its_f64_interval() {
    let det = |a: [Near; 3], b: [Near; 3], c: [Near; 3]| {
        let minor = |i: usize, j: usize| b[i].mul(c[j]).sub(b[j].mul(c[i]));
        a[0].mul(minor(1, 2)).add(a[1].mul(minor(2, 0))).add(a[2].mul(minor(0, 1)))
    };
    let near = |p: [f32; 3]| p.map(|x| Near(f64::from(x), 0.0));
    let mut asked = 0;
    for family in FAMILIES {
        let mut rng = Rng::new(34);
        for _ in 0..200 {
            let Case { triangle, ray, .. } = family.case(&mut rng);
            let Some(t) = exact_t(&triangle, &ray) else { continue };
            let o = near(ray.origin);
            let [a, b, c] = triangle.0.map(near).map(|p| [0, 1, 2].map(|k| p[k].sub(o[k])));
            let d = near(ray.dir);
            let num = det(a, b, c);
            let den = det(d, b, c).add(det(d, c, a)).add(det(d, a, b));
            if den.1 > den.0.abs() / 2.0 {
                continue;
            }
            // |t - num / den| <= (error of num + |t| error of den) / |den|, doubled for safety.
            let off = (num.0 / den.0 - t.to_f64().value()).abs();
            let bound = 2.0 * (num.1 + (num.0 / den.0).abs() * den.1) / den.0.abs();
            assert!(off <= bound * 1.01, "{}: {off:e} {bound:e}", family.name);
            asked += 1;
        }
    }
    assert!(asked > 4000, "{asked}");
}

#[test]
fn the_reference_is_nearly_right() {
    // For ordinary f32 inputs, f64 arithmetic gives the exact answer, except where rays meet a side
    // or a corner exactly.
    let mut rng = Rng::new(35);
    let (mut differ, mut worst, mut hits) = (0, 0.0_f64, 0);
    let family = find("random").unwrap();
    for _ in 0..20_000 {
        let Case { triangle, ray, threshold } = family.case(&mut rng);
        let scene = F64Scene::from_triangles([triangle.0]).with_threshold(threshold);
        let mut t = f64::NAN;
        let hit = scene.inter_tri(0, &F64Ray::new(ray.origin, ray.dir), &mut t) == 1;
        let exact = answer(&triangle, &ray);
        if matches!(exact.place, LinePosition::Inside | LinePosition::Outside) {
            differ += u32::from(hit != exact.is_hit());
        }
        if hit && exact.is_hit() {
            hits += 1;
            worst = worst.max(t_error(t, &exact_t(&triangle, &ray).unwrap()));
        }
    }
    assert!(differ == 0 && hits > 8000, "{differ} differ, {hits} hits");
    assert!(worst < 1e-9, "{worst:e}");
}

#[test]
fn places_of_a_plain_triangle() {
    let triangle = Triangle::new([0.0, 0.0, 1.0], [4.0, 0.0, 1.0], [0.0, 4.0, 1.0]);
    let ask = |o: [f32; 3], d: [f32; 3]| answer(&triangle, &Ray::new(o, d));
    let front = |place| OracleAnswer { place, t: Ordering::Greater };
    let none = |place| OracleAnswer { place, t: Ordering::Equal };
    let up = [0.0, 0.0, 2.0];
    assert_eq!(ask([1.0, 1.0, 0.0], up), front(LinePosition::Inside));
    assert_eq!(
        ask([1.0, 1.0, 2.0], up),
        OracleAnswer { place: LinePosition::Inside, t: Ordering::Less }
    );
    assert_eq!(
        ask([1.0, 1.0, 1.0], up),
        OracleAnswer { place: LinePosition::Inside, t: Ordering::Equal }
    );
    assert_eq!(ask([2.0, 2.0, 0.0], up), front(LinePosition::Edge(0)));
    assert_eq!(ask([0.0, 2.0, 0.0], up), front(LinePosition::Edge(1)));
    assert_eq!(ask([2.0, 0.0, 0.0], up), front(LinePosition::Edge(2)));
    assert_eq!(ask([0.0, 0.0, 0.0], up), front(LinePosition::Vertex(0)));
    assert_eq!(ask([4.0, 0.0, 0.0], up), front(LinePosition::Vertex(1)));
    assert_eq!(ask([0.0, 4.0, 0.0], up), front(LinePosition::Vertex(2)));
    assert_eq!(ask([5.0, -1.0, 0.0], up), front(LinePosition::Outside));
    assert_eq!(ask([-1.0, -0.0, 0.0], up), front(LinePosition::Outside));
    assert_eq!(ask([-1.0, 0.0, 1.0], [1.0, 0.0, 0.0]), none(LinePosition::Coplanar));
    assert_eq!(ask([-1.0, 0.0, 0.0], [1.0, 0.0, 0.0]), none(LinePosition::Parallel));
    assert_eq!(ask([1.0, 1.0, 0.0], [0.0; 3]), none(LinePosition::Parallel));
    assert_eq!(ask([1.0, 1.0, 0.0], [0.0, f32::NAN, 1.0]), none(LinePosition::NotFinite));
    let line = Triangle::new([0.0; 3], [1.0; 3], [3.0; 3]);
    assert_eq!(answer(&line, &Ray::new([0.0, 0.0, -1.0], up)), none(LinePosition::Degenerate));
}

#[test]
fn errors_of_t_are_measured_exactly() {
    let two_thirds = Rational::from(2) / Rational::from(3);
    assert!(t_error_ulps(2.0 / 3.0, &two_thirds) < 0.5);
    assert!(t_error_ulps_f32(2.0 / 3.0, &two_thirds) < 0.5);
    let off = t_error_ulps_f32((2.0_f32 / 3.0).next_up().next_up(), &two_thirds);
    assert!((1.5..2.5).contains(&off), "{off}");
    assert_eq!(t_error(1.0, &two_thirds), 0.5);
    assert_eq!(t_error(0.25, &Rational::from(0)), 0.25);
    assert_eq!(t_error(f64::INFINITY, &two_thirds), f64::INFINITY);
    assert!(t_error_ulps(f64::NAN, &two_thirds).is_nan());
    // The exact t is too large for f32, so the error of an f32 answer is infinite.
    let huge = Rational::try_from(1e200).unwrap();
    assert_eq!(t_error_ulps_f32(f32::INFINITY, &huge), f64::INFINITY);
    assert!(t_error_ulps(1e200, &huge) == 0.0);
}

#[test]
fn nothing_panics_on_the_mix() {
    let mut rng = Rng::new(36);
    for _ in 0..3000 {
        let Case { triangle, ray, .. } = adversarial(&mut rng);
        let place = answer(&triangle, &ray).place;
        assert_eq!(exact_t(&triangle, &ray).is_some(), place > LinePosition::Parallel);
    }
}
