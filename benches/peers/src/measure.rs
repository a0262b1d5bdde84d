//! Measures one cell of the table: several engines take turns tracing the same rays.
//!
//! On one thread, the rays of a repeat are timed in parts, and the clock rate is sampled before and
//! after each part. A dip in the clock rate then invalidates only one part instead of the whole
//! repeat.

use std::ops::Range;
use std::time::Instant;

use intertri::Ray;
use rayon::ThreadPool;
use serde::{Deserialize, Serialize};

use crate::clock::Clock;
use crate::engine::{Engine, Question};
use crate::rays::Order;
use crate::truth::Truth;

/// The measurements of an engine.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub struct Row {
    pub scene: String,
    pub triangles: usize,
    pub kind: String,
    /// The severity of the hostile case, for `cliffs`.
    #[serde(default)]
    pub amount: f64,
    pub order: String,
    pub threads: usize,
    pub engine: String,
    pub rays: usize,
    /// Millions of rays per second: low, median and high, from the slow, median and fast times of
    /// each part of the rays.
    pub speed: [f64; 3],
    /// The number of timed parts that count.
    pub repeats: usize,
    /// The number of timed parts discarded because of an unusual clock rate.
    pub dips: usize,
    /// The engine that `ratio` refers to.
    pub base: String,
    /// The factor by which this engine was faster than `base` in the same round: low, median and
    /// high. It is `None` if no part counts for both engines in the same round.
    pub ratio: Option<[f64; 3]>,
    /// The number of rays with a hit reported as a miss or vice versa.
    pub wrong_hits: usize,
    /// The number of rays with a hit on a wrong triangle (or with a wrong t, if the engine
    /// guarantees every bit of t). [`Truth`] decides when either of two triangles is correct.
    pub wrong_triangles: usize,
    /// The number of true answers compared with a plain loop over the reference.
    pub reference: usize,
    /// The number of compared answers that differed from those of the plain loop.
    pub reference_wrong: usize,
}

impl Row {
    /// Fills in the description of a measurement on one thread: the scene and its number of
    /// triangles, and the kind and order of the rays.
    pub fn of(self, scene: &str, triangles: usize, kind: &str, order: Order) -> Self {
        let order = order.name().into();
        Self { scene: scene.into(), triangles, kind: kind.into(), order, threads: 1, ..self }
    }
}

/// A function that takes the name of an engine and returns the true answers for it.
pub type TruthOf<'a> = &'a dyn Fn(&str) -> Truth<'a>;

/// A function that takes the rows and the index of one of them, and returns the index of the row to
/// compare it with.
pub type Beside = fn(&[Row], usize) -> Option<usize>;

/// An engine and its name.
pub type Named = (String, Box<dyn Engine>);

/// The number of rays that are timed together on one thread. If the clock rate dips for a few
/// milliseconds, only a few parts are affected.
const PART: usize = 1 << 16;

/// The number of valid times that each part needs.
const TIMES: usize = 3;

/// The seconds that each part of each repeat took, or `None` if the clock rate was unusual.
type Rounds = Vec<Vec<Option<f64>>>;

/// The seconds and the clock rate of each part in each repeat of an engine.
#[derive(Default)]
struct Times {
    rounds: Vec<Vec<(f64, f64)>>,
    spent: f64,
    /// Each engine has its own usual clock rate, because some CPUs lower it for wide instructions.
    clock: Clock,
}

impl Times {
    /// Adds the parts of another repeat.
    fn add(&mut self, round: Vec<(f64, f64)>) {
        for &(seconds, at) in &round {
            self.clock.add(at);
            self.spent += seconds;
        }
        self.rounds.push(round);
    }

    /// Returns the times of the parts that count, in seconds.
    fn kept(&self) -> Rounds {
        let counts = |&(seconds, at): &(f64, f64)| self.clock.is_steady(at).then_some(seconds);
        self.rounds.iter().map(|round| round.iter().map(counts).collect()).collect()
    }

    /// Returns whether to stop measuring: once the budget is used up and each part has enough valid
    /// times, and in any case after about four times the budget.
    fn enough(&self, budget: f64) -> bool {
        if self.spent < budget {
            return false;
        }
        let kept = self.kept();
        let times = |part: usize| kept.iter().filter(|round| round[part].is_some()).count();
        let all = kept.first().is_some_and(|round| (0..round.len()).all(|p| times(p) >= TIMES));
        self.spent >= 4.0 * budget + 0.5 || all
    }
}

/// Splits the rays of a round into the parts that are timed separately.
fn parts(rays: usize, threads: usize) -> impl Iterator<Item = Range<usize>> + Clone {
    let size = if threads == 1 { PART } else { rays };
    (0..rays).step_by(size).map(move |from| from..rays.min(from + size))
}

/// Computes millions of rays per second from the slow, median and fast times of each part. Parts
/// without valid times are skipped.
fn speed(rounds: &[Vec<Option<f64>>], parts: impl Iterator<Item = Range<usize>>) -> [f64; 3] {
    let (mut rays, mut seconds) = (0, [0.0; 3]);
    for (i, part) in parts.enumerate() {
        let times: Vec<f64> = rounds.iter().filter_map(|round| round[i]).collect();
        rays += if times.is_empty() { 0 } else { part.len() };
        for (sum, time) in seconds.iter_mut().zip(spread(times)) {
            *sum += time;
        }
    }
    let [fast, middle, slow] = seconds;
    [slow, middle, fast].map(|seconds| if rays > 0 { rays as f64 * 1e-6 / seconds } else { 0.0 })
}

/// Returns the ratio of the time of `b` to that of `a` in a round, over the parts that count for
/// both.
fn ratio(a: &[Option<f64>], b: &[Option<f64>]) -> Option<f64> {
    let (mut of_a, mut of_b) = (0.0, 0.0);
    for (a, b) in a.iter().zip(b).filter_map(|(a, b)| Some(((*a)?, (*b)?))) {
        of_a += a;
        of_b += b;
    }
    (of_a > 0.0).then(|| of_b / of_a)
}

/// Runs all engines round-robin until each has used its time. Returns the rows without the fields
/// that describe the scene.
pub fn measure(
    engines: &mut [Named],
    rays: &[Ray],
    question: Question,
    truth: TruthOf<'_>,
    budget: f64,
    pool: &ThreadPool,
    beside: Beside,
) -> Vec<Row> {
    for (_, engine) in engines.iter_mut() {
        engine.load(rays, question);
        pool.install(|| engine.trace(0..rays.len()));
    }
    let parts = parts(rays.len(), pool.current_num_threads());
    let mut times: Vec<_> = engines.iter().map(|_| Times::default()).collect();
    while times.iter().any(|times| !times.enough(budget)) {
        for ((_, engine), times) in engines.iter_mut().zip(&mut times) {
            if !times.enough(budget) {
                times.add(pool.install(|| time_parts(engine.as_mut(), parts.clone())));
            }
        }
    }

    let kept: Vec<_> = times.iter().map(|times| times.kept()).collect();
    let row = |(engine, rounds): (&Named, &Rounds)| {
        let speed = speed(rounds, parts.clone());
        row(engine, rounds, speed, rays.len(), &truth(&engine.0))
    };
    let mut rows: Vec<Row> = engines.iter().zip(&kept).map(row).collect();
    compare(&mut rows, &kept, beside);
    rows
}

/// Runs one repeat of an engine, and returns the seconds and the clock rate of each part.
fn time_parts(
    engine: &mut dyn Engine,
    parts: impl Iterator<Item = Range<usize>> + Clone,
) -> Vec<(f64, f64)> {
    // The other engines have evicted this engine's scene from the caches. A program that traces with
    // one engine would not see that, and engines with little work per ray suffer most.
    parts.clone().for_each(|part| engine.trace(part));

    let mut before = Clock::now();
    let part = |part| {
        let start = Instant::now();
        engine.trace(part);
        let seconds = start.elapsed().as_secs_f64();
        let after = Clock::now();
        (seconds, std::mem::replace(&mut before, after).min(after))
    };
    parts.map(part).collect()
}

/// Returns an engine's row, without the comparison with another engine.
fn row(
    (name, engine): &Named,
    rounds: &Rounds,
    speed: [f64; 3],
    rays: usize,
    truth: &Truth<'_>,
) -> Row {
    let [wrong_hits, wrong_triangles] = truth.wrong(&engine.answers(), engine.exact());
    let all = rounds.iter().flatten().count();
    let repeats = rounds.iter().flatten().flatten().count();
    Row {
        engine: name.clone(),
        rays,
        speed,
        repeats,
        dips: all - repeats,
        wrong_hits,
        wrong_triangles,
        ..Row::default()
    }
}

/// Returns the fastest of Embree's fast calls. For an engine limited to AVX2, only calls limited to
/// AVX2 are considered.
pub fn embree(rows: &[Row], engine: usize) -> Option<usize> {
    let avx2 = rows[engine].engine.contains("avx2");
    let group = if avx2 { "embree-avx2" } else { "embree-fast" };
    let of = |&i: &usize| {
        rows[i].engine.strip_prefix(group).is_some_and(|rest| !rest.contains("robust"))
    };
    let speed = |i: usize| rows[i].speed[1];
    (0..rows.len()).filter(of).max_by(|&a, &b| speed(a).total_cmp(&speed(b)))
}

/// Compares each engine with the one that `beside` chooses.
fn compare(rows: &mut [Row], kept: &[Rounds], beside: Beside) {
    for i in 0..rows.len() {
        let Some(base) = beside(rows, i) else { continue };
        let rounds = kept[i].iter().zip(&kept[base]);
        let ratios: Vec<f64> = rounds.filter_map(|(a, b)| ratio(a, b)).collect();
        rows[i].ratio = (!ratios.is_empty()).then(|| spread(ratios));
        rows[i].base = rows[base].engine.clone();
    }
}

/// Returns the 10th, 50th and 90th percentiles, or zeros if there are no values.
fn spread(mut x: Vec<f64>) -> [f64; 3] {
    x.sort_by(f64::total_cmp);
    let at = |share: f64| x.get((share * (x.len().max(1) - 1) as f64).round() as usize);
    [0.1, 0.5, 0.9].map(|share| at(share).copied().unwrap_or(0.0))
}

#[cfg(test)]
mod tests {
    use std::ops::Range;

    use super::*;
    use crate::engine::Answer;

    /// A tracer that returns the same answer for every ray.
    struct Fake {
        answer: Answer,
        rays: usize,
    }

    impl Engine for Fake {
        fn load(&mut self, rays: &[Ray], _: Question) {
            self.rays = rays.len();
        }

        fn trace(&mut self, _: Range<usize>) {}

        fn answers(&self) -> Vec<Answer> {
            vec![self.answer; self.rays]
        }
    }

    #[test]
    fn each_engine_is_charged_with_its_own_wrong_answers() {
        let hit = |triangle| Answer { triangle, t: 1.0 };
        let fake =
            |name: &str, answer| -> Named { (name.to_owned(), Box::new(Fake { answer, rays: 0 })) };
        let mut engines =
            [fake("misses", Answer::MISS), fake("hits", hit(0)), fake("confuses", hit(1))];
        let answers = [hit(0), hit(0), hit(0), Answer::MISS];
        let rays = [Ray::new([0.0; 3], [0.0, 0.0, 1.0]); 4];
        let question = Question { any: false, coherent: true };
        let pool =
            rayon::ThreadPoolBuilder::new().num_threads(1).build().expect("the thread starts");
        let truth = |_: &str| Truth::without_ties(&answers);
        let rows = measure(&mut engines, &rays, question, &truth, 0.0, &pool, |_, _| None);
        let wrong = |row: &Row| (row.engine.clone(), row.wrong_hits, row.wrong_triangles);
        assert_eq!(
            rows.iter().map(wrong).collect::<Vec<_>>(),
            [("misses".into(), 3, 0), ("hits".into(), 1, 0), ("confuses".into(), 1, 3)]
        );
        assert!(rows.iter().all(|row| row.rays == 4));
    }

    #[test]
    fn ratios_are_to_the_fastest_of_embrees_fast_calls_on_the_same_instructions() {
        let row = |engine: &str, speed: f64| Row {
            engine: engine.into(),
            speed: [speed; 3],
            ..Row::default()
        };
        let rows = [
            row("exact", 50.0),
            row("exact-avx2", 40.0),
            row("embree-fast-1", 10.0),
            row("embree-fast-16", 20.0),
            row("embree-robust-16", 30.0),
            row("embree-avx2-8", 15.0),
            row("embree-avx2-robust-8", 16.0),
        ];
        assert_eq!(embree(&rows, 0), Some(3));
        assert_eq!(embree(&rows, 1), Some(5));
        assert_eq!(embree(&rows[..2], 0), None);
    }
}
