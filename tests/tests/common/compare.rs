//! Compares the results for pairs of a ray and a triangle with rational arithmetic: hits under both
//! rules at every tier, the ends of the interval, the order of hits, and the rounding of t, u and
//! v.

use core::cmp::Ordering;

use intertri::internal::exact::{
    self, EightPairs, PairDecision, Side, Tier, attributes, attributes_from, attributes32,
    crossing_from, order, order_by_coordinates, order_from, t, t_from,
};
use intertri::simd::Level;
use intertri::{RayOf, Rule, Scalar, TriangleOf};
use intertri_lab::rng::Rng;
use intertri_tests::oracle::{self, Truth, truth};

/// A scalar that can be stepped to the next lower and the next higher value.
pub(crate) trait Float: Scalar {
    fn below(self) -> Self;
    fn above(self) -> Self;
}

macro_rules! floats {
    ($($float:ty),*) => {$(
        impl Float for $float {
            fn below(self) -> Self {
                self.next_down()
            }

            fn above(self) -> Self {
                self.next_up()
            }
        }
    )*};
}

floats!(f32, f64);

/// The number of comparisons of each kind.
#[derive(Clone, Copy, Debug, Default)]
struct Counts {
    pairs: usize,
    hits: usize,
    crossings: usize,
    ends: usize,
    rounded: usize,
    equal: usize,
    ordered: usize,
    walls: usize,
    eight: usize,
}

impl Counts {
    fn add(&mut self, more: Self) {
        self.pairs += more.pairs;
        self.hits += more.hits;
        self.crossings += more.crossings;
        self.ends += more.ends;
        self.rounded += more.rounded;
        self.equal += more.equal;
        self.ordered += more.ordered;
        self.walls += more.walls;
        self.eight += more.eight;
    }
}

/// The exact result for a pair. It does not depend on the ray's interval.
struct Case<S: Scalar> {
    triangle: TriangleOf<S>,
    truth: Option<Truth>,
    /// Whether the ray crosses the triangle in the direction of the normal, or `None` if it does
    /// not cross the triangle.
    once: Option<bool>,
}

/// Checks the case with `ray`, which is the case's ray with an arbitrary interval. Checks every
/// tier if `all` is set.
fn check<S: Scalar>(ray: &RayOf<S>, case: &Case<S>, all: bool, counts: &mut Counts) {
    let Case { triangle, truth, once: leaves } = case;
    let truth = truth.as_ref().filter(|truth| truth.is_within(ray));
    let is_hit = truth.is_some_and(Truth::is_closed_hit);
    let crossing = leaves.filter(|_| truth.is_some());
    let crossing = crossing.map(|leaves| if leaves { Side::Leaves } else { Side::Enters });
    assert_eq!(exact::hit(Rule::Closed, ray, triangle), is_hit, "{ray:?} {triangle:?}");
    assert_eq!(exact::hit(Rule::Once, ray, triangle), crossing.is_some(), "{ray:?} {triangle:?}");
    assert_eq!(exact::crossing(ray, triangle), crossing, "{ray:?} {triangle:?}");
    for &tier in Tier::all::<S>().iter().filter(|_| all) {
        let of = |rule| crossing_from(tier, rule, ray, triangle);
        assert_eq!(of(Rule::Closed).is_some(), is_hit, "{tier:?} {ray:?} {triangle:?}");
        assert_eq!(of(Rule::Once), crossing, "{tier:?} {ray:?} {triangle:?}");
    }
    check_eight((ray, triangle), truth, [is_hit, crossing.is_some()], counts);
    counts.hits += usize::from(is_hit);
    counts.crossings += usize::from(crossing.is_some());
}

/// Checks what is decided about a pair alone, and about eight pairs side by side, under both rules and
/// at every level.
fn check_eight<S: Scalar>(
    (ray, triangle): (&RayOf<S>, &TriangleOf<S>),
    truth: Option<&Truth>,
    hits: [bool; 2],
    counts: &mut Counts,
) {
    let mut eight = EightPairs::new();
    (0..8).for_each(|lane| eight.set(lane, ray, triangle));
    for (rule, hit) in [Rule::Closed, Rule::Once].into_iter().zip(hits) {
        for level in Level::all() {
            let decisions = eight.decide(level, rule);
            assert!(decisions.iter().all(|other| *other == decisions[0]), "{decisions:?}");
            counts.eight += usize::from(decisions[0].is_some());
            check_decision(decisions[0], truth.filter(|_| hit), (rule, ray, triangle));
        }
        let alone = exact::decide_pair(rule, ray, triangle);
        check_decision(Some(alone), truth.filter(|_| hit), (rule, ray, triangle));
    }
}

/// Checks a decision about a pair, if any. The pair is a hit if `truth` is given.
fn check_decision<S: Scalar>(
    decision: Option<PairDecision>,
    truth: Option<&Truth>,
    pair: (Rule, &RayOf<S>, &TriangleOf<S>),
) {
    match decision {
        None => {}
        Some(PairDecision::HitAt(_)) => unreachable!("only document A has this t"),
        Some(PairDecision::Miss) => assert!(truth.is_none(), "{pair:?}"),
        Some(PairDecision::Hit { t_lo, t_hi, edges }) => {
            let t = truth.map(Truth::t_f64);
            let is_within = |t| f64::from(t_lo) <= t && t <= f64::from(t_hi);
            assert!(t.is_some_and(is_within), "{t:?} {pair:?}");
            let met = truth.map_or(0, Truth::edges);
            assert!(edges & !met == 0, "{edges:03b} {met:03b} {pair:?}");
        }
    }
}

/// Checks intervals that begin or end at t or at a neighbour of t.
fn check_ends<S: Float>(ray: &RayOf<S>, case: &Case<S>, truth: &Truth, counts: &mut Counts) {
    let near = S::nearest(truth.t_f64());
    for end in [near.below(), near, near.above()] {
        check(&RayOf { t_min: end, ..*ray }, case, true, counts);
        check(&RayOf { t_max: end, ..*ray }, case, true, counts);
        counts.ends += 2;
    }
    let (nan, infinity) = (f32::NAN, f32::INFINITY);
    let others = [(nan, 9.0), (0.0, nan), (-1.0, -0.0), (-2.0, 1.0), (-nan, 1.0)];
    let others = others.into_iter().chain([(infinity, infinity), (-infinity, infinity)]);
    let others = others.map(|(t_min, t_max)| (S::from(t_min), S::from(t_max)));
    for (t_min, t_max) in others.chain([(near, near)]) {
        check(&RayOf { t_min, t_max, ..*ray }, case, true, counts);
    }
}

/// Checks t, u and v, at every tier if `all` is set.
fn check_rounding<S: Scalar>(
    (ray, triangle): (&RayOf<S>, &TriangleOf<S>),
    truth: &Truth,
    all: bool,
    counts: &mut Counts,
) {
    let (t, (first, u, v)) = (t(ray, triangle), attributes(ray, triangle));
    let right = truth.are_rounded([t, u, v]);
    assert!(right && first == t, "{t} {u} {v} {ray:?} {triangle:?}");
    let in_f32 = attributes32(ray, triangle);
    assert!(truth.are_rounded_to_f32(in_f32), "{in_f32:?} {ray:?} {triangle:?}");
    let bits = |(t, u, v): (f64, f64, f64)| [t, u, v].map(f64::to_bits);
    for &tier in Tier::all::<S>().iter().filter(|_| all) {
        assert_eq!(t_from(tier, ray, triangle), t, "{tier:?} {ray:?} {triangle:?}");
        let all = attributes_from(tier, ray, triangle);
        assert_eq!(bits(all), bits((t, u, v)), "{tier:?} {ray:?} {triangle:?}");
    }
    counts.rounded += 6;
}

/// Checks how the triangle is ordered relative to others: copies with permuted or moved corners,
/// and neighbours at an edge or a corner, in or near its plane.
fn check_order<S: Float>(
    ray: &RayOf<S>,
    triangle: &TriangleOf<S>,
    truth: &Truth,
    counts: &mut Counts,
) {
    let [c1, c2, c3] = triangle.0;
    let mut moved = *triangle;
    let number = &mut moved.0[1][usize::from(ray.dir[0] > S::ZERO)];
    *number = number.above();
    let beside = |a: [S; 3], b: [S; 3]| {
        [0, 1, 2].map(|k| S::nearest(a[k].into() + b[k].into() - c3[(k + 1) % 3].into()))
    };
    let (near, far) = (beside(c1, c2), beside(c2, c2));
    let turned = [TriangleOf([c2, c3, c1]), TriangleOf([c1, c3, c2]), moved];
    let neighbours =
        [TriangleOf([near, c2, c1]), TriangleOf([c1, near, c3]), TriangleOf([far, c1, near])];
    for other in turned.into_iter().chain(neighbours) {
        let Some(of_other) = oracle::truth(ray, &other) else { continue };
        let want = truth.order(&of_other);
        assert_eq!(order(ray, triangle, &other), want, "{ray:?} {triangle:?} {other:?}");
        for &tier in Tier::all::<S>() {
            assert_eq!(order_from(tier, ray, triangle, &other), want, "{ray:?} {triangle:?}");
            assert_eq!(order_from(tier, ray, &other, triangle), want.reverse());
        }
        *if want.is_eq() { &mut counts.equal } else { &mut counts.ordered } += 1;
    }

    // Compare walls perpendicular to each axis: a wall with itself, and with a wall one ulp farther
    // along the axis.
    for axis in 0..3 {
        let wall = |at: S| {
            TriangleOf(triangle.0.map(|mut corner| {
                corner[axis] = at;
                corner
            }))
        };
        let (here, next) = (wall(c1[axis]), wall(c1[axis].above()));
        let (Some(truth), Some(of_next)) = (oracle::truth(ray, &here), oracle::truth(ray, &next))
        else {
            continue;
        };
        let want = truth.order(&of_next);
        assert_eq!(
            order_by_coordinates(ray, &here, &next),
            Some(want),
            "{ray:?} {here:?} {next:?}"
        );
        assert_eq!(order_by_coordinates(ray, &next, &here), Some(want.reverse()));
        assert_eq!(order_by_coordinates(ray, &here, &here), Some(Ordering::Equal));
        counts.walls += 1;
    }
}

/// A function that generates a pair of a given kind.
type Draw<S> = fn(usize, &mut Rng) -> (RayOf<S>, TriangleOf<S>);

/// A generator of pairs of several kinds.
#[derive(Clone, Copy)]
pub(crate) struct Cases<S: Scalar> {
    pub(crate) kinds: usize,
    pub(crate) case: Draw<S>,
}

impl<S: Float> Cases<S> {
    /// Compares pairs of each kind with rational arithmetic, starting from a seed, and returns the
    /// counts for each kind. A larger `seldom` makes slow checks rarer.
    fn run(self, pairs: usize, seed: u64, seldom: usize) -> Vec<Counts> {
        let mut all = vec![Counts::default(); self.kinds];
        let mut rng = Rng::new(seed);
        for i in 0..pairs * self.kinds {
            let (round, kind) = (i / self.kinds, i % self.kinds);
            let (ray, triangle) = (self.case)(kind, &mut rng);
            let (truth, counts) = (truth(&ray, &triangle), &mut all[kind]);
            let case =
                Case { triangle, once: oracle::once(&ray, &triangle, truth.as_ref()), truth };
            check(&ray, &case, round.is_multiple_of(4 * seldom), counts);
            counts.pairs += 1;

            // Also check t, u and v of some rays that meet the plane outside the triangle.
            let Some(truth) = &case.truth else { continue };
            let is_hit = truth.is_closed_hit();
            if is_hit && round % (16 * seldom) == 1 || round % (64 * seldom) == 2 {
                check_ends(&ray, &case, truth, counts);
                check_order(&ray, &triangle, truth, counts);
            }
            let all = is_hit && round % (4 * seldom) < 2 || round.is_multiple_of(16 * seldom);
            if all || is_hit && round % 4 < 2 {
                check_rounding((&ray, &triangle), truth, all, counts);
            }
        }
        all
    }

    /// Runs the comparison on all threads, each with its own counts.
    fn run_on_all(self, pairs: usize, seed: u64, seldom: usize) -> Vec<Vec<Counts>> {
        let threads = std::thread::available_parallelism().map_or(1, Into::into);
        std::thread::scope(|scope| {
            let one =
                |i| scope.spawn(move || self.run(pairs.div_ceil(threads), seed + i as u64, seldom));
            let all: Vec<_> = (0..threads).map(one).collect();
            all.into_iter().map(|thread| thread.join().unwrap()).collect()
        })
    }

    /// Compares pairs of each kind, and checks that enough of each were compared.
    pub(crate) fn agree(self, pairs: usize) {
        let all = self.run_on_all(pairs, 1, 1);
        println!("{all:#?}");
        for kinds in all {
            let Counts { hits, crossings, ends, rounded, equal, ordered, walls, eight, .. } =
                sum(&kinds);
            let least = hits
                .min(crossings)
                .min(ends)
                .min(rounded)
                .min(equal)
                .min(ordered)
                .min(walls)
                .min(eight);
            assert!(least > 100);
        }
    }

    /// Compares as many pairs as the environment variable `INTERTRI_EXACT_PAIRS` specifies,
    /// starting from the seed in `INTERTRI_EXACT_SEED`.
    pub(crate) fn agree_for_hours(self) {
        let number = |name, default| std::env::var(name).map_or(default, |n| n.parse().unwrap());
        let pairs: usize = number("INTERTRI_EXACT_PAIRS", 100_000_000);
        let seed = number("INTERTRI_EXACT_SEED", 1_000) as u64;
        let a_round = 250_000_usize.div_ceil(self.kinds);
        let mut all = vec![Counts::default(); self.kinds];
        let by_kind = |all: &[Counts]| {
            all.iter().enumerate().for_each(|(kind, counts)| println!("  kind {kind}: {counts:?}"));
        };
        for round in 0..pairs.div_ceil(a_round * self.kinds) {
            for kinds in self.run_on_all(a_round, seed + 100 * round as u64, 16) {
                all.iter_mut().zip(kinds).for_each(|(sum, counts)| sum.add(counts));
            }
            println!("{:?}", sum(&all));
            if round % 40 == 39 {
                by_kind(&all);
            }
        }
        by_kind(&all);
    }
}

/// Returns the sum of the counts of all kinds.
fn sum(kinds: &[Counts]) -> Counts {
    let mut all = Counts::default();
    for kind in kinds {
        all.add(*kind);
    }
    all
}
