//! Measures how closely the errors of the `certified` mode approach their bounds. It compares the
//! filter's values with exact arithmetic, for cases from every family and in a search that climbs
//! toward the largest error.
//!
//! `docs/numerics/certified.md` derives the bounds. A share above 1 would refute the derivation. If
//! a share stays small, the constant is larger than necessary.

use dashu_ratio::Relaxed;
use intertri::internal::Evidence;
use intertri::simd::Level;
use intertri::{Ray, Threshold, Triangle};
use intertri_lab::families::{Case, FAMILIES};
use intertri_lab::rng::{Rng, step};
use intertri_reference as reference;
use intertri_tests::reference_ray;

/// Half an ulp of 1 in f32.
const U: f64 = 1.0 / (1 << 24) as f64;

type Exact = [Relaxed; 3];

fn sub(a: &Exact, b: &Exact) -> Exact {
    [0, 1, 2].map(|i| &a[i] - &b[i])
}

fn dot(a: &Exact, b: &Exact) -> Relaxed {
    &a[0] * &b[0] + &a[1] * &b[1] + &a[2] * &b[2]
}

fn cross(a: &Exact, b: &Exact) -> Exact {
    [(1, 2), (2, 0), (0, 1)].map(|(i, j)| &a[i] * &b[j] - &a[j] * &b[i])
}

fn real(x: impl Into<f64>) -> Relaxed {
    Relaxed::try_from(x.into()).expect("the number is finite")
}

fn float(x: &Relaxed) -> f64 {
    x.to_f64().value()
}

/// The share of each bound that an intersection test uses. A share is 0 if its bound does not
/// apply.
#[derive(Clone, Copy, Debug, Default)]
struct Shares([f64; 14]);

/// The names of the shares, which are the columns of the printed table:
///
/// - the errors of V, W, U, D and T relative to their bounds; if only the sign matters, the
///   rounding of the last sum does not count;
/// - the distance of the reference's t from the middle of its enclosure, relative to half of the
///   enclosure;
/// - *box*: how far the bounds of T and D allow the quotient T/D to be from its computed value,
///   relative to half of the enclosure;
/// - *rho*: how thin the triangle and how grazing the ray of a decided case are, relative to the
///   limit of 2^20.1 that the proof assumes;
/// - *sharp V, W* and *sharp U*: the errors of V, W and U relative to the bounds of the last
///   attempt;
/// - *sharp T* and *sharp t*: the error of T relative to the bound of the last attempt, and the
///   position of the reference's t in the remaining enclosure;
/// - *noise*: the largest |V|, |W| or |U| whose sign the reference gets wrong, relative to the
///   bound;
/// - *precheck* and *precheck D*: the errors of V, W and U, and of D, relative to the precheck's
///   bound.
const NAMES: [&str; 14] = [
    "V, W",
    "U",
    "D",
    "T",
    "t",
    "box",
    "rho",
    "sharp V, W",
    "sharp U",
    "noise",
    "sharp T",
    "sharp t",
    "precheck",
    "precheck D",
];

/// The edges of a triangle, the direction of a ray, and the five terms of the intersection test,
/// without rounding.
struct Terms {
    h4: Exact,
    h5: Exact,
    dir: Exact,
    v: Relaxed,
    w: Relaxed,
    u: Relaxed,
    den: Relaxed,
    num: Relaxed,
}

impl Terms {
    fn of(ray: &Ray, triangle: &Triangle) -> Self {
        let [o, d] = [ray.origin, ray.dir].map(|p| p.map(real));
        let [c1, c2, c3] = triangle.0.map(|c| c.map(real));
        let (a, h4, h5) = (sub(&c1, &o), sub(&c2, &c1), sub(&c3, &c1));
        let (r, n) = (cross(&d, &a), cross(&h4, &h5));
        let (v, w) = (-dot(&h5, &r), dot(&h4, &r));
        let (den, num) = (dot(&n, &d), dot(&n, &a));
        let u = &den - &v - &w;
        Self { h4, h5, dir: d, v, w, u, den, num }
    }

    /// Returns the factor by which the reference's noise is magnified, relative to the limit that
    /// the proof allows.
    fn rho(&self) -> f64 {
        let length = |x: &Exact| float(&dot(x, x)).sqrt();
        let rho = length(&self.h4) * length(&self.h5) * length(&self.dir) / float(&self.den).abs();
        rho / 20.1_f64.exp2()
    }
}

/// Returns the absolute error of a computed value.
fn off(hat: f32, exact: &Relaxed) -> f64 {
    float(&(real(hat) - exact)).abs()
}

/// Returns the error of a sum as a share of its bound. The rounding of the last addition is not
/// counted, because it cannot change the sign.
fn share(hat: f32, exact: &Relaxed, bound: f32) -> f64 {
    (off(hat, exact) - U * f64::from(hat.abs())).max(0.0) / f64::from(bound)
}

/// The reference's tables for a triangle, the ray in the reference's type, and the t that the
/// reference computes.
struct Reference {
    tables: reference::Scene,
    line: reference::Ray,
    t: f64,
}

impl Reference {
    fn of(ray: &Ray, triangle: &Triangle) -> Self {
        let tables = reference::Scene::from_triangles([triangle.0]).with_threshold(0.0);
        let line = reference_ray(ray);
        let mut t = 0.0;
        tables.inter_tri(0, &line, &mut t);
        Self { tables, line, t }
    }

    /// Returns the largest magnitude of a term whose sign the reference gets wrong, relative to the
    /// term's bound. This share shows how far from an edge the reference may still choose the wrong
    /// side. The reference's three values are computed with document A's operations.
    fn noise(&self, exact: &Terms, sharp: [f32; 3]) -> f64 {
        let Self { tables, line, t } = self;
        let tri = &tables.trian[0];
        let h1 = line.org + line.dir * *t;
        let (h2, h3) = (h1 - tables.vertx[0], h1 - tables.vertx[1]);
        let values = [tri.nrm & (h2 ^ tri.h5), tri.nrm & (tri.h4 ^ h2), tri.nrm & (tri.h6 ^ h3)];
        let side = if float(&exact.den) < 0.0 { -1.0 } else { 1.0 };
        let mut noise = 0.0_f64;
        for (value, (exact, bound)) in
            values.iter().zip([&exact.v, &exact.w, &exact.u].into_iter().zip(sharp))
        {
            let exact = side * float(exact);
            if (*value < 0.0) != (exact < 0.0) {
                noise = noise.max(exact.abs() / f64::from(bound));
            }
        }
        noise
    }
}

/// Returns three shares: how much of the enclosure of t the reference's t uses, how much of it the
/// quotients allowed by the bounds of D and T use, and how much of the last attempt's enclosure the
/// reference's t uses.
fn enclosure(seen: &Evidence, t: f64) -> [f64; 3] {
    let [lo, hi] = [seen.t_lo, seen.t_hi].map(f64::from);
    if !(hi.is_finite() && lo.is_finite()) {
        return [0.0; 3];
    }
    let (middle, half) = (f64::midpoint(lo, hi), (hi - lo) / 2.0);
    let enclosure = (t - middle).abs() / half;
    let [lo, hi] = seen.sharp_t.map(f64::from);
    let sharp_t = (t - f64::midpoint(lo, hi)).abs() / ((hi - lo) / 2.0);
    let [num, num_err, den, den_err] =
        [seen.num.abs(), seen.num_err, seen.den.abs(), seen.den_err].map(f64::from);
    let quotients = ((num + num_err) / (den - den_err) - num / den) / half;
    [enclosure, quotients, sharp_t]
}

/// Checks that the filter does not reject an interval that barely contains the reference's t.
fn interval_holds(case: &Case, t: f64, level: Level) {
    let near = t as f32;
    if t > 0.0 && near.is_finite() {
        let at_least = if f64::from(near) < t { near.next_up() } else { near };
        let at_most = if f64::from(near) > t { near.next_down() } else { near };
        for (t_min, t_max) in [(0.0, at_least), (at_most, f32::INFINITY)] {
            let ray = case.ray.between(t_min, t_max);
            let seen = Evidence::of(&ray, &case.triangle, Threshold::ZERO, level);
            assert!(!seen.out_of_range, "{t} is rejected in {t_min}..{t_max}\n{case:?}");
        }
    }
}

impl Shares {
    /// Returns the shares that a test uses at one level, or `None` if an input is not finite or an
    /// f32 operation overflows, because the filter then decides nothing.
    fn of(case: &Case, level: Level) -> Option<Self> {
        let Case { ray, triangle, threshold } = case;
        let seen = Evidence::of(ray, triangle, Threshold::new(*threshold).ok()?, level);
        let Evidence { v, w, u, edge, u_edge, den, den_err, num, num_err, .. } = seen;
        let all = [v, w, u, edge, u_edge, den, den_err, num, num_err, seen.precheck_bound];
        let mut all = all.iter().chain(&seen.precheck).chain(triangle.0.iter().flatten());
        if !all.all(|x| x.is_finite()) {
            return None;
        }

        let exact = Terms::of(ray, triangle);
        let mut shares = Self::of_terms(&seen, &exact);
        if seen.sure {
            let reference = Reference::of(ray, triangle);
            interval_holds(case, reference.t, level);
            let [t, quotients, sharp_t] = enclosure(&seen, reference.t);
            shares.0[4..=6].copy_from_slice(&[t, quotients, exact.rho()]);
            shares.0[9] = reference.noise(&exact, seen.sharp);
            shares.0[11] = sharp_t;
        }
        Some(shares)
    }

    /// Returns the errors of the terms relative to their bounds, in the precheck, in the filter,
    /// and at the last attempt.
    fn of_terms(seen: &Evidence, exact: &Terms) -> Self {
        let &Evidence { v, w, u, edge, u_edge, den, den_err, num, num_err, .. } = seen;
        let share_vw = share(v, &exact.v, edge).max(share(w, &exact.w, edge));
        let share_u = share(u, &exact.u, u_edge);
        let [sharp_v, sharp_w, sharp_u] = seen.sharp;
        let sharp_vw = share(v, &exact.v, sharp_v).max(share(w, &exact.w, sharp_w));
        let sharp_u = share(u, &exact.u, sharp_u);
        let share_d = off(den, &exact.den) / f64::from(den_err);
        let share_t = off(num, &exact.num) / f64::from(num_err);
        let sharp_num = off(num, &exact.num) / f64::from(seen.sharp_num);
        let h = real(seen.h);
        let before =
            |hat: f32, exact: &Relaxed| off(hat, &(exact / &h)) / f64::from(seen.precheck_bound);
        let [pre_v, pre_w, pre_u, pre_d] = seen.precheck;
        let precheck_d = before(pre_d, &exact.den);
        let precheck =
            before(pre_v, &exact.v).max(before(pre_w, &exact.w)).max(before(pre_u, &exact.u));
        Self([
            share_vw, share_u, share_d, share_t, 0.0, 0.0, 0.0, sharp_vw, sharp_u, 0.0, sharp_num,
            0.0, precheck, precheck_d,
        ])
    }

    fn join(&mut self, other: &Self) {
        self.0 = std::array::from_fn(|i| self.0[i].max(other.0[i]));
    }

    fn print(&self, name: &str) {
        println!("{name:20} {:7.3?}", self.0);
    }
}

/// Returns a level with separate multiplications and additions, and one with fused operations if
/// the CPU has them.
fn levels() -> impl Iterator<Item = Level> {
    [Some(Level::PORTABLE), Level::avx2()].into_iter().flatten()
}

fn print_names() {
    println!("{:20} {NAMES:?}", "share of");
}

#[test]
fn no_family_uses_more_than_the_bound() {
    let of = |family: &intertri_lab::families::Family| {
        let (mut rng, mut most) = (Rng::new(11), Shares::default());
        for _ in 0..3000 {
            let case = family.case(&mut rng);
            for shares in levels().filter_map(|level| Shares::of(&case, level)) {
                assert!(shares.0.iter().all(|&x| x <= 1.0), "{shares:?}\n{case:?}");
                most.join(&shares);
            }
        }
        (family.name, most)
    };
    let halves = [0, 1].map(|k| FAMILIES.iter().skip(k).step_by(2));
    let rows = std::thread::scope(|scope| {
        let workers = halves.map(|half| scope.spawn(move || half.map(of).collect::<Vec<_>>()));
        workers.map(|w| w.join().expect("no worker panics")).concat()
    });
    print_names();
    for (name, most) in rows {
        most.print(name);
    }
}

/// Makes a case from fifteen numbers: the ray's origin and direction, and the triangle's three
/// corners.
fn case(x: &[f32; 15]) -> Case {
    let p = |i: usize| [x[i], x[i + 1], x[i + 2]];
    Case { ray: Ray::new(p(0), p(3)), triangle: Triangle::new(p(6), p(9), p(12)), threshold: 0.0 }
}

/// Searches for a larger share from a starting point, changing one to three numbers per step.
/// Returns the largest share and the input that produces it.
fn climb(
    rng: &mut Rng,
    level: Level,
    what: usize,
    steps: usize,
    start: [f32; 15],
) -> (f64, [f32; 15]) {
    let mut best = start;
    let share = |x: &[f32; 15]| Shares::of(&case(x), level).map_or(0.0, |s| s.0[what]);
    let mut most = share(&best);
    for _ in 0..steps {
        let mut x = best;
        for _ in 0..=rng.below(3) {
            let i = rng.below(15);
            x[i] = match rng.below(16) {
                0 => x[i] * (0.5 + rng.unit() as f32),
                1 => -x[i],
                2 => x[rng.below(15)],
                3 => x[i] * 2.0,
                4 | 5 => x[i] * 0.5,
                6 => x[i] * (1.0 + rng.signed() as f32 * 1e-2),
                7 => x[i] * (1.0 + rng.signed() as f32 * 1e-4),
                8 => f32::from_bits(x[i].to_bits() ^ 1 << rng.below(23)),
                9 | 10 => step(x[i], rng.within(1000)),
                _ => step(x[i], rng.within(8)),
            };
        }
        if x.iter().any(|x| x.abs() < 1e-12) {
            continue;
        }
        let share = share(&x);
        assert!(share <= 1.0, "{} uses {share} of its bound\n{:?}", NAMES[what], case(&x));
        if share >= most {
            (best, most) = (x, share);
        }
    }
    (most, best)
}

/// Generates a starting point for a search. The two edges, the vector to the first corner and the
/// direction are each almost parallel to an axis, so that every product is nearly the product of
/// the vectors' lengths, and every sum has to be rounded.
fn start(rng: &mut Rng) -> [f32; 15] {
    let mut near_axis = || {
        let mut x = [0; 3].map(|_| rng.signed() * rng.log(1e-6, 1e-1));
        x[rng.below(3)] += if rng.one_in(2) { 1.0 } else { -1.0 };
        x
    };
    let [a, d, h4, h5] = [(); 4].map(|()| near_axis());
    let origin = [0; 3].map(|_| rng.signed() * rng.log(1e-6, 1e1));
    let add = |p: [f64; 3], q: [f64; 3]| [0, 1, 2].map(|i| p[i] + q[i]);
    let c1 = add(origin, a);
    let all = [origin, d, c1, add(c1, h4), add(c1, h5)];
    std::array::from_fn(|i| all[i / 3][i % 3] as f32)
}

/// The results of earlier searches. Each entry contains the index of the column, the name of the
/// constant that the case proves necessary, if any, and the fifteen numbers of the case.
#[rustfmt::skip]
#[expect(clippy::unreadable_literal, reason = "the literals are data")]
const FOUND: [(usize, &str, [f32; 15]); 11] = [
    (0, "EDGE", [
        -0.015973011, 2.0034714, 0.0063019227, 5.794106e-5, -0.0045461035,
        2.0034668, -0.12520248, -0.031945825, -0.006337226, 0.00056717545,
        -0.008038396, -0.0045427894, -0.010662427, -0.010662427, 0.015548073,
    ]),
    (1, "U", [
        -0.00080236, -2.4028993e-6, 4.094513e-5, -0.50005174, 0.0009322114,
        8.642438e-5, 0.010827807, 0.0007106066, -0.0119086495, 0.0059819035,
        -1.0033108, -2.0230525, 0.010783884, -2.0014074, -0.0037486854,
    ]),
    (1, "NEAR", [
        1.1493188, 0.015340227, -0.025362717, -0.94744325, -6.144774e-5,
        4.526711e-5, 1.1492223, 0.015333832, -0.025373638, 1.0767767,
        0.0052620466, 1.1492252, 1.1466609, -0.9846734, 0.53834367,
    ]),
    (2, "DEN", [
        -0.0037603606, 0.010114852, 0.0069094845, 0.99999994, 0.006909356,
        -0.00023752917, 0.0011369294, -0.2952755, 1.0091325, -0.0015549563,
        -1.2953027, 0.504585, 0.033023622, -0.2883385, 0.009134323,
    ]),
    (3, "NUM", [
        1.0000329, 0.00013034852, 0.00011309057, -4.6196424e-6, -6.0652474e-5,
        -6.065289e-5, 2.0205975e-5, 1.9609926e-5, -9.238718e-6, 0.00055843446,
        -1.0140933, -4.665125e-6, -0.00017663768, -0.53430676, 1.0000204,
    ]),
    (4, "", [
        -0.4827296, 0.0029334761, 0.0008725524, 0.5082255, -3.090358e-6,
        -0.5775234, -0.57758963, 0.000872571, 1.0047958, -8.6426735e-7,
        1.0633746, 0.5041684, 0.2893422, 0.0011758114, 0.0029333234,
    ]),
    (5, "SLACK", [
        -0.006605828, -0.021213619, 0.024649706, 1.0080678, -0.04868098,
        -0.04990237, -0.004629991, -1.9813439, 2.0880117, -0.0060576214,
        0.01181835, -3.487919, -5.216687e-5, 0.0090479255, -3.481301,
    ]),
    (6, "GRAZING", [
        -0.006605828, -0.021213619, 0.024649706, 1.0080678, -0.04868098,
        -0.04990237, -0.004629991, -1.9813439, 2.0880117, -0.0060576214,
        0.01181835, -3.487919, -5.216687e-5, 0.0090479255, -3.481301,
    ]),
    (7, "SHARP", [
        -0.015973011, 2.0034714, 0.0063019227, 5.794106e-5, -0.0045461035,
        2.0034668, -0.12520248, -0.031945825, -0.006337226, 0.00056717545,
        -0.008038396, -0.0045427894, -0.010662427, -0.010662427, 0.015548073,
    ]),
    (8, "SHARP_U", [
        -0.00080236, -2.4028993e-6, 4.094513e-5, -0.50005174, 0.0009322114,
        8.642438e-5, 0.010827807, 0.0007106066, -0.0119086495, 0.0059819035,
        -1.0033108, -2.0230525, 0.010783884, -2.0014074, -0.0037486854,
    ]),
    (10, "SHARP_NUM", [
        1.0000329, 0.00013034852, 0.00011309057, -4.6196424e-6, -6.0652474e-5,
        -6.065289e-5, 2.0205975e-5, 1.9609926e-5, -9.238718e-6, 0.00055843446,
        -1.0140933, -4.665125e-6, -0.00017663768, -0.53430676, 1.0000204,
    ]),
];

/// Tests that the constants named in [`FOUND`] are needed: if one of them were halved, a case would
/// exceed its bound.
#[test]
fn half_of_a_constant_would_not_do() {
    print_names();
    for (what, constant, start) in FOUND {
        let (mut most, mut row) = (0.0_f64, Shares::default());
        for level in levels() {
            let (share, x) = climb(&mut Rng::new(21), level, what, 2000, start);
            most = most.max(share);
            row.join(&Shares::of(&case(&x), level).expect("the filter decides the case"));
        }
        row.print(&format!("search for {}", NAMES[what]));
        assert!(constant.is_empty() || most > 0.5, "{constant} is too large: {most}");
    }
}

/// Searches from many starting points. No search may find a case that exceeds a bound.
#[test]
fn no_search_gets_beyond_the_bound() {
    let search = |what: usize| {
        let mut rng = Rng::new(31 + what as u64);
        for level in levels() {
            for _ in 0..20 {
                let start = start(&mut rng);
                climb(&mut rng, level, what, 300, start);
            }
        }
    };
    std::thread::scope(|scope| {
        for k in 0..2 {
            scope.spawn(move || (k..NAMES.len()).step_by(2).for_each(search));
        }
    });
}
