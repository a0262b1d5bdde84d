//! One cell of the table: some engines, the same rays, one after the other and again.

use std::time::Instant;

use intertri::Ray;
use rayon::ThreadPool;
use serde::{Deserialize, Serialize};

use crate::clock::Clock;
use crate::engine::{Answer, Engine, Question};

/// What was seen of an engine.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub struct Row {
    pub scene: String,
    pub triangles: usize,
    pub kind: String,
    pub order: String,
    pub threads: usize,
    pub engine: String,
    pub rays: usize,
    /// Million rays a second: the slowest repeat that counts, the middle one, the fastest.
    pub speed: [f64; 3],
    /// Repeats that count, and those thrown out because the clock was another than usual.
    pub repeats: usize,
    pub dips: usize,
    /// Of which engine the ratio tells, and how many times as fast this one was in the same round:
    /// the lowest, the middle, the highest.
    pub base: String,
    pub ratio: Option<[f64; 3]>,
    /// Rays with hit and miss mistaken, and with a hit on another triangle (or, where every bit of t
    /// is promised, of another t).
    pub wrong_hits: usize,
    pub wrong_triangles: usize,
    /// Rays whose truth was held against the plain loop of the reference, and how many differed.
    pub reference: usize,
    pub reference_wrong: usize,
}

/// An engine and its name.
pub type Named = (String, Box<dyn Engine>);

/// Seconds of each repeat of an engine, and the clock meanwhile.
struct Times {
    rounds: Vec<(f64, f64)>,
    spent: f64,
}

impl Times {
    /// The seconds of each repeat; `None` where the clock was another than usual.
    fn kept(&self, clock: &Clock) -> Vec<Option<f64>> {
        let counts = |&(seconds, at): &(f64, f64)| clock.is_steady(at).then_some(seconds);
        self.rounds.iter().map(counts).collect()
    }

    /// Whether there is enough: the time spent and some repeats, or no hope for a steady clock.
    fn enough(&self, budget: f64, clock: &Clock) -> bool {
        self.spent >= 4.0 * budget + 0.5
            || self.spent >= budget && self.kept(clock).iter().flatten().count() >= 3
    }
}

/// Runs all engines in turn until each had so many seconds; then the rows, with everything but what
/// is to be known of the scene.
pub fn measure(
    engines: &mut [Named],
    rays: &[Ray],
    question: Question,
    truth: &[Answer],
    budget: f64,
    pool: &ThreadPool,
) -> Vec<Row> {
    let clock = &mut Clock::default();
    for (_, engine) in engines.iter_mut() {
        engine.load(rays, question);
        pool.install(|| engine.trace());
    }
    let mut times: Vec<_> =
        engines.iter().map(|_| Times { rounds: Vec::new(), spent: 0.0 }).collect();
    while times.iter().any(|times| !times.enough(budget, clock)) {
        for ((_, engine), times) in engines.iter_mut().zip(&mut times) {
            if times.enough(budget, clock) {
                continue;
            }
            let (seconds, at) = pool.install(|| {
                let before = Clock::now();
                let start = Instant::now();
                engine.trace();
                let seconds = start.elapsed().as_secs_f64();
                (seconds, before.min(Clock::now()))
            });
            clock.add(at);
            times.rounds.push((seconds, at));
            times.spent += seconds;
        }
    }

    let kept: Vec<_> = times.iter().map(|times| times.kept(clock)).collect();
    let speed = |seconds: f64| rays.len() as f64 * 1e-6 / seconds;
    let row = |((name, engine), rounds): (&Named, &Vec<Option<f64>>)| {
        let answers = engine.answers();
        let (mut wrong_hits, mut wrong_triangles) = (0, 0);
        for (answer, truth) in answers.iter().zip(truth) {
            if answer.is_hit() != truth.is_hit() {
                wrong_hits += 1;
            } else if answer.triangle != truth.triangle || engine.exact() && answer.t != truth.t {
                wrong_triangles += 1;
            }
        }
        let repeats = rounds.iter().flatten().count();
        Row {
            engine: name.clone(),
            rays: rays.len(),
            speed: spread(rounds.iter().flatten().map(|&seconds| speed(seconds)).collect()),
            repeats,
            dips: rounds.len() - repeats,
            wrong_hits,
            wrong_triangles,
            ..Row::default()
        }
    };
    let mut rows: Vec<Row> = engines.iter().zip(&kept).map(row).collect();

    // Against the fastest of Embree's fast calls, of those held to AVX2 for who is held to AVX2.
    let best = |group: &str| {
        let of = |&i: &usize| {
            rows[i].engine.strip_prefix(group).is_some_and(|rest| !rest.contains("robust"))
        };
        let speed = |i: usize| rows[i].speed[1];
        (0..rows.len()).filter(of).max_by(|&a, &b| speed(a).total_cmp(&speed(b)))
    };
    let (any_level, avx2) = (best("embree-fast"), best("embree-avx2"));
    for i in 0..rows.len() {
        let base = if rows[i].engine.contains("avx2") { avx2 } else { any_level };
        let Some(base) = base else { continue };
        let rounds = kept[base].iter().zip(&kept[i]);
        rows[i].ratio = Some(spread(rounds.filter_map(|(a, b)| Some((*a)? / (*b)?)).collect()));
        rows[i].base = rows[base].engine.clone();
    }
    rows
}

/// The tenth, the fiftieth and the ninetieth of a hundred; zeros of none.
fn spread(mut x: Vec<f64>) -> [f64; 3] {
    x.sort_by(f64::total_cmp);
    let at = |share: f64| x.get((share * (x.len().max(1) - 1) as f64).round() as usize);
    [0.1, 0.5, 0.9].map(|share| at(share).copied().unwrap_or(0.0))
}
