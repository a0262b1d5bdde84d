//! Pairs against rationals: both rules at every tier, the interval's ends, order, and the rounding of t, u, v.

use intertri::internal::exact::{
    self, Rule, Side, Tier, attributes, attributes_from, crossing_from, order, order_from, t,
    t_from,
};
use intertri::{Crossing, Exact, Hit, Mode, Ray, Triangle};
use intertri_lab::rng::Rng;
use intertri_tests::oracle::{self, Truth, truth};
use intertri_trace::Bvh;

use crate::cases::{KINDS, case};

/// How many of what were compared.
#[derive(Clone, Copy, Debug, Default)]
struct Counts {
    pairs: usize,
    hits: usize,
    crossings: usize,
    ends: usize,
    rounded: usize,
    equal: usize,
    ordered: usize,
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
    }
}

/// What is true of a pair, whatever the interval.
struct Case {
    triangle: Triangle,
    truth: Option<Truth>,
    /// Whether the ray leaves, if it crosses the triangle.
    once: Option<bool>,
}

/// Asks about a ray, which is the pair's but for its interval; at every tier, if all shall be.
fn check(ray: &Ray, case: &Case, all: bool, counts: &mut Counts) {
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
fn check_ends(ray: &Ray, case: &Case, truth: &Truth, counts: &mut Counts) {
    let near = truth.t_f32();
    for end in [near.next_down(), near, near.next_up()] {
        check(&Ray { t_min: end, ..*ray }, case, true, counts);
        check(&Ray { t_max: end, ..*ray }, case, true, counts);
        counts.ends += 2;
    }
    let (nan, infinity) = (f32::NAN, f32::INFINITY);
    let others = [(nan, 9.0), (0.0, nan), (near, near), (-1.0, -0.0), (-2.0, 1.0), (-nan, 1.0)];
    for (t_min, t_max) in others.into_iter().chain([(infinity, infinity), (-infinity, infinity)]) {
        check(&Ray { t_min, t_max, ..*ray }, case, true, counts);
    }
}

/// t, u and v; at every tier, if all shall be.
fn check_rounding(
    (ray, triangle): (&Ray, &Triangle),
    truth: &Truth,
    all: bool,
    counts: &mut Counts,
) {
    let (t, (first, u, v)) = (t(ray, triangle), attributes(ray, triangle));
    let right = truth.are_rounded([t, u, v]);
    assert!(right && first == t, "{t} {u} {v} {ray:?} {triangle:?}");
    let bits = |(t, u, v): (f64, f64, f64)| [t, u, v].map(f64::to_bits);
    for tier in Tier::ALL.into_iter().filter(|_| all) {
        assert_eq!(t_from(tier, ray, triangle), t, "{tier:?} {ray:?} {triangle:?}");
        let all = attributes_from(tier, ray, triangle);
        assert_eq!(bits(all), bits((t, u, v)), "{tier:?} {ray:?} {triangle:?}");
    }
    counts.rounded += 3;
}

/// One triangle before another, or both at one t: that of the same plane, one beside it, and neighbours at an
/// edge and at a corner.
fn check_order(ray: &Ray, triangle: &Triangle, truth: &Truth, counts: &mut Counts) {
    let [c1, c2, c3] = triangle.0;
    let mut moved = *triangle;
    let number = &mut moved.0[1][usize::from(ray.dir[0] > 0.0)];
    *number = number.next_up();
    let beside = |a: [f32; 3], b: [f32; 3]| [0, 1, 2].map(|k| a[k] + b[k] - c3[(k + 1) % 3]);
    let (near, far) = (beside(c1, c2), beside(c2, c2));
    let turned = [Triangle([c2, c3, c1]), Triangle([c1, c3, c2]), moved];
    let neighbours =
        [Triangle([near, c2, c1]), Triangle([c1, near, c3]), Triangle([far, c1, near])];
    for other in turned.into_iter().chain(neighbours) {
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

/// So many pairs of each kind, from a seed; one in `seldom` is asked what takes long. The counts of each kind.
fn run(pairs: usize, seed: u64, seldom: usize) -> [Counts; KINDS] {
    let mut all = [Counts::default(); KINDS];
    let mut rng = Rng::new(seed);
    for i in 0..pairs * KINDS {
        let (round, kind) = (i / KINDS, i % KINDS);
        let (ray, triangle) = case(kind, &mut rng);
        let (truth, counts) = (truth(&ray, &triangle), &mut all[kind]);
        let case = Case { triangle, once: oracle::once(&ray, &triangle, truth.as_ref()), truth };
        check(&ray, &case, round.is_multiple_of(4 * seldom), counts);
        counts.pairs += 1;

        // What a hit is asked for is asked of some planes that are met beside their triangle, too.
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

/// On all threads.
fn run_on_all(pairs: usize, seed: u64, seldom: usize) -> Vec<[Counts; KINDS]> {
    let threads = std::thread::available_parallelism().map_or(1, Into::into);
    std::thread::scope(|scope| {
        let one = |i| scope.spawn(move || run(pairs.div_ceil(threads), seed + i as u64, seldom));
        let all: Vec<_> = (0..threads).map(one).collect();
        all.into_iter().map(|thread| thread.join().unwrap()).collect()
    })
}

/// Those of all kinds together.
fn sum(kinds: &[Counts; KINDS]) -> Counts {
    let mut all = Counts::default();
    for kind in kinds {
        all.add(*kind);
    }
    all
}

#[test]
fn every_tier_agrees_with_rationals() {
    let all = run_on_all(80_000, 1, 1);
    println!("{all:#?}");
    for kinds in all {
        let Counts { hits, crossings, ends, rounded, equal, ordered, .. } = sum(&kinds);
        let least = hits.min(crossings).min(ends).min(rounded).min(equal).min(ordered);
        assert!(least > 100);
    }
}

/// An f64 product of the edges of this triangle rounds, and the normal is 0; but it has an area, and is hit.
#[test]
fn a_triangle_without_an_f64_normal_is_hit() {
    let [a, b, c] = [[2.320_720_7e-9, 2.320_721_2e-9], [1.705_962; 2], [3.411_924; 2]];
    let triangle = Triangle([a, b, c].map(|[x, y]: [f32; 2]| [x, y, 0.0]));
    assert_eq!(triangle.normal(), [0.0; 3]);
    for [x, y, z] in triangle.0 {
        assert!(exact::hit(&Ray::new([x, y, z - 1.0], [0.0, 0.0, 1.0]), &triangle));
        assert!(exact::hit(&Ray::new([x, y, z + 1.0], [0.0, 0.0, -1.0]), &triangle));
    }
}

/// Two t that f64 cannot tell apart: everything that gives an order gives the exact one, not that of the indices.
#[test]
fn equal_rounded_t_are_told_apart() {
    // Through the middle of both: t is the mean of the three heights.
    let at = |z: f32| {
        let heights = [1.0, 2.0_f32.powi(-30), z];
        let corners = [[-1.0, -1.0], [2.0, -1.0], [-1.0, 2.0]];
        Triangle([0, 1, 2].map(|i| [corners[i][0], corners[i][1], heights[i]]))
    };
    let triangles = [at(2.0_f32.powi(-60)), at(2.0_f32.powi(-61)), at(2.0_f32.powi(-61))];
    let ray = Ray::new([0.0, 0.0, 0.0], [0.0, 0.0, 1.0]);
    assert!(triangles.iter().all(|triangle| t(&ray, triangle) == t(&ray, &triangles[0])));
    let (mode, bvh) = (Exact::default(), Bvh::new(&triangles).unwrap());
    let numbers = |hits: Vec<Hit>| hits.iter().map(|hit| hit.triangle).collect::<Vec<_>>();
    let crossings = |all: Vec<Crossing>| numbers(all.iter().map(|one| one.hit).collect());
    assert_eq!(numbers(mode.all(&triangles, &ray)), [1, 2, 0]);
    assert_eq!(numbers(bvh.all(&mode, &ray)), [1, 2, 0]);
    assert_eq!(crossings(mode.crossings(&triangles, &ray)), [1, 2, 0]);
    assert_eq!(crossings(bvh.crossings(&mode, &ray)), [1, 2, 0]);
    let mut hits = vec![Hit::MISS; 2000];
    bvh.closest_batch(&mode, &vec![ray; 2000], &mut hits);
    hits[0] = mode.closest(&triangles, &ray).unwrap();
    hits[1] = bvh.closest(&mode, &ray).unwrap();
    assert!(hits.iter().all(|hit| hit.triangle == 1));
}

/// By hand: `cargo test --release -p intertri-tests --test exact -- --ignored --nocapture`; so many pairs by
/// `INTERTRI_EXACT_PAIRS`, the first of them by `INTERTRI_EXACT_SEED`.
#[test]
#[ignore = "takes hours"]
fn a_hundred_million_pairs_agree_with_rationals() {
    let number = |name, default| std::env::var(name).map_or(default, |n| n.parse().unwrap());
    let pairs: usize = number("INTERTRI_EXACT_PAIRS", 100_000_000);
    let seed = number("INTERTRI_EXACT_SEED", 1_000) as u64;
    let (a_round, mut all) = (250_000_usize.div_ceil(KINDS), [Counts::default(); KINDS]);
    for round in 0..pairs.div_ceil(a_round * KINDS) {
        for kinds in run_on_all(a_round, seed + 100 * round as u64, 16) {
            all.iter_mut().zip(kinds).for_each(|(sum, counts)| sum.add(counts));
        }
        println!("{:?}", sum(&all));
        if round % 40 == 39 {
            all.iter().enumerate().for_each(|(kind, counts)| println!("  kind {kind}: {counts:?}"));
        }
    }
    all.iter().enumerate().for_each(|(kind, counts)| println!("  kind {kind}: {counts:?}"));
}
