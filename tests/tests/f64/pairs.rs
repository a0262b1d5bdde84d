//! Pairs against rationals: both rules at every tier, the interval's ends, order, and the rounding of t, u, v.

use intertri::internal::exact::{
    self, Rule, Side, Tier, attributes, attributes_from, crossing_from, order, order_from, t,
    t_from,
};
use intertri::{Ray64, Triangle64};
use intertri_lab::rng::Rng;
use intertri_tests::oracle::{self, Truth, truth};

use crate::cases::{KINDS, case};

/// How many of what were compared.
#[derive(Clone, Copy, Debug, Default)]
struct Counts {
    hits: usize,
    crossings: usize,
    ends: usize,
    rounded: usize,
    equal: usize,
    ordered: usize,
}

/// What is true of a pair, whatever the interval.
struct Case {
    triangle: Triangle64,
    truth: Option<Truth>,
    /// Whether the ray leaves, if it crosses the triangle.
    once: Option<bool>,
}

/// Asks about a ray, which is the pair's but for its interval; at every tier, if all shall be.
fn check(ray: &Ray64, case: &Case, all: bool, counts: &mut Counts) {
    let Case { triangle, truth, once: leaves } = case;
    let truth = truth.as_ref().filter(|truth| truth.is_within(ray));
    let is_hit = truth.is_some_and(Truth::is_closed_hit);
    let crossing = leaves.filter(|_| truth.is_some());
    let crossing = crossing.map(|leaves| if leaves { Side::Leaves } else { Side::Enters });
    assert_eq!(exact::hit(ray, triangle), is_hit, "{ray:?} {triangle:?}");
    assert_eq!(exact::crossing(ray, triangle), crossing, "{ray:?} {triangle:?}");
    for tier in Tier::ALL.into_iter().filter(|_| all) {
        let of = |rule| crossing_from(tier, rule, ray, triangle);
        assert_eq!(of(Rule::Closed).is_some(), is_hit, "{tier:?} {ray:?} {triangle:?}");
        assert_eq!(of(Rule::Once), crossing, "{tier:?} {ray:?} {triangle:?}");
    }
    counts.hits += usize::from(is_hit);
    counts.crossings += usize::from(crossing.is_some());
}

/// The ends of the interval at t and beside it.
fn check_ends(ray: &Ray64, case: &Case, truth: &Truth, counts: &mut Counts) {
    let near = truth.t_f64();
    for end in [near.next_down(), near, near.next_up()] {
        check(&Ray64 { t_min: end, ..*ray }, case, true, counts);
        check(&Ray64 { t_max: end, ..*ray }, case, true, counts);
        counts.ends += 2;
    }
    let (nan, infinity) = (f64::NAN, f64::INFINITY);
    let others = [(nan, 9.0), (0.0, nan), (near, near), (-1.0, -0.0), (-2.0, 1.0), (-nan, 1.0)];
    for (t_min, t_max) in others.into_iter().chain([(infinity, infinity), (-infinity, infinity)]) {
        check(&Ray64 { t_min, t_max, ..*ray }, case, true, counts);
    }
}

/// t, u and v at every tier.
fn check_rounding(ray: &Ray64, triangle: &Triangle64, truth: &Truth, counts: &mut Counts) {
    let (t, (first, u, v)) = (t(ray, triangle), attributes(ray, triangle));
    let right = truth.are_rounded([t, u, v]);
    assert!(right && first == t, "{t} {u} {v} {ray:?} {triangle:?}");
    let bits = |(t, u, v): (f64, f64, f64)| [t, u, v].map(f64::to_bits);
    for tier in Tier::ALL {
        assert_eq!(t_from(tier, ray, triangle), t, "{tier:?} {ray:?} {triangle:?}");
        let all = attributes_from(tier, ray, triangle);
        assert_eq!(bits(all), bits((t, u, v)), "{tier:?} {ray:?} {triangle:?}");
    }
    counts.rounded += 3;
}

/// One triangle before another, or both at one t: that of the same plane, and one beside it.
fn check_order(ray: &Ray64, triangle: &Triangle64, truth: &Truth, counts: &mut Counts) {
    let [c1, c2, c3] = triangle.0;
    let mut moved = *triangle;
    let number = &mut moved.0[1][usize::from(ray.dir[0] > 0.0)];
    *number = number.next_up();
    for other in [Triangle64([c2, c3, c1]), Triangle64([c1, c3, c2]), moved] {
        let Some(of_other) = oracle::truth(ray, &other) else { continue };
        let want = truth.order(&of_other);
        assert_eq!(order(ray, triangle, &other), want, "{ray:?} {triangle:?} {other:?}");
        for tier in Tier::ALL {
            assert_eq!(order_from(tier, ray, triangle, &other), want, "{ray:?} {triangle:?}");
            assert_eq!(order_from(tier, ray, &other, triangle), want.reverse());
        }
        *if want.is_eq() { &mut counts.equal } else { &mut counts.ordered } += 1;
    }
}

/// So many pairs of each kind, from a seed.
fn run(pairs: usize, seed: u64) -> Counts {
    let mut counts = Counts::default();
    let mut rng = Rng::new(seed);
    for i in 0..pairs * KINDS {
        let (round, kind) = (i / KINDS, i % KINDS);
        let (ray, triangle) = case(kind, &mut rng);
        let truth = truth(&ray, &triangle);
        let case = Case { triangle, once: oracle::once(&ray, &triangle, truth.as_ref()), truth };
        check(&ray, &case, round.is_multiple_of(4), &mut counts);

        // What a hit is asked for is asked of some planes that are met beside their triangle, too.
        let Some(truth) = &case.truth else { continue };
        let is_hit = truth.is_closed_hit();
        if is_hit && round % 16 == 1 || round % 64 == 2 {
            check_ends(&ray, &case, truth, &mut counts);
            check_order(&ray, &triangle, truth, &mut counts);
        }
        if is_hit && round % 4 < 2 || round.is_multiple_of(16) {
            check_rounding(&ray, &triangle, truth, &mut counts);
        }
    }
    counts
}

/// On all threads.
fn run_on_all(pairs: usize, seed: u64) -> Vec<Counts> {
    let threads = std::thread::available_parallelism().map_or(1, Into::into);
    std::thread::scope(|scope| {
        let one = |i| scope.spawn(move || run(pairs.div_ceil(threads), seed + i as u64));
        let all: Vec<_> = (0..threads).map(one).collect();
        all.into_iter().map(|thread| thread.join().unwrap()).collect()
    })
}

#[test]
fn every_tier_agrees_with_rationals() {
    let all = run_on_all(12_000, 1);
    println!("{all:#?}");
    for Counts { hits, crossings, ends, rounded, equal, ordered, .. } in all {
        let least = hits.min(crossings).min(ends).min(rounded).min(equal).min(ordered);
        assert!(least > 100);
    }
}
