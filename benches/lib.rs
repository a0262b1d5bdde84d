//! What the benchmarks share: the workload, and a table of ratios measured side by side.

use std::time::Instant;

use intertri::{Ray, Triangle};
use intertri_lab::rng::Rng;

pub mod moller_trumbore;

/// Rays and triangles of a benchmark.
#[derive(Debug)]
pub struct Workload {
    /// Rays, of which neighbours are alike.
    pub rays: Vec<Ray>,
    /// Triangles.
    pub triangles: Vec<Triangle>,
}

impl Workload {
    /// Triangles with corners anywhere in a cube, rays from one side through it; about one test in
    /// ten is a hit. With `shared` all rays start at one point, as a camera's do.
    pub fn random(rays: usize, triangles: usize, shared: bool) -> Self {
        let mut rng = Rng::new(7);
        let f32s = |v: [f64; 3]| v.map(|x| x as f32);
        let eye = [0.1, 0.2, -3.0];
        let ray = |rng: &mut Rng| {
            let origin = if shared { eye } else { [rng.signed(), rng.signed(), rng.signed() - 3.0] };
            let target = rng.cube();
            let dir = [0, 1, 2].map(|k| target[k] - origin[k]);
            let length = dir.iter().map(|x| x * x).sum::<f64>().sqrt();
            Ray::new(f32s(origin), f32s(dir.map(|x| x / length)))
        };
        let small = std::env::var("SMALL").map_or(1.0, |s| s.parse().unwrap_or(1.0));
        let triangle = |rng: &mut Rng| {
            let c = rng.cube();
            let mut corner = || { let d = rng.cube(); f32s([0, 1, 2].map(|k| c[k] + small * (d[k] - c[k]))) };
            Triangle([corner(), corner(), corner()])
        };
        Self {
            rays: (0..rays).map(|_| ray(&mut rng)).collect(),
            triangles: (0..triangles).map(|_| triangle(&mut rng)).collect(),
        }
    }
}

/// What a contender answers: how many hits there are, and the bits of all their t, mixed.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Answer {
    /// The number of hits.
    pub hits: u64,
    /// The exclusive or of the bits of t.
    pub t: u64,
}

impl Answer {
    /// Adds a hit.
    #[inline(always)]
    pub fn add(&mut self, t: f64) {
        self.hits += 1;
        self.t ^= t.to_bits();
    }
}

/// A contender: a name, what it runs, and whether its answer is held against the first one's.
pub struct Contender<'a> {
    /// What stands in the table.
    pub name: String,
    /// Does all the tests of the workload once.
    pub run: Box<dyn FnMut() -> Answer + 'a>,
    /// Whether its answer must be the first contender's.
    pub exact: bool,
}

/// Runs all contenders in turn, again and again, and prints each one's time against the first's.
///
/// The turns are short, so that a dip of the clock hits all alike; the ratio is the median of the
/// ratios within a turn, with the tenth and ninetieth percentile.
///
/// # Panics
/// If an answer is wrong.
pub fn compare(title: &str, tests: usize, turns: usize, contenders: &mut [Contender<'_>]) {
    let truth = (contenders[0].run)();
    let mut times = vec![vec![]; contenders.len()];
    for turn in 0..turns + 2 {
        for (contender, times) in contenders.iter_mut().zip(&mut times) {
            let start = Instant::now();
            let answer = std::hint::black_box((contender.run)());
            let time = start.elapsed().as_secs_f64();
            assert!(!contender.exact || answer == truth, "{}: {answer:?} {truth:?}", contender.name);
            // The first turns warm up.
            if turn >= 2 {
                times.push(time);
            }
        }
    }
    println!("\n{title}: {tests} tests a turn, {} hits, {turns} turns in alternation", truth.hits);
    println!("{:36} {:>10} {:>28}", "", "ns a test", "times the scalar reference");
    for (contender, own) in contenders.iter().zip(&times) {
        let mut ratios: Vec<f64> = times[0].iter().zip(own).map(|(a, b)| a / b).collect();
        ratios.sort_by(f64::total_cmp);
        let mut own = own.clone();
        own.sort_by(f64::total_cmp);
        let at = |q: f64| ratios[((ratios.len() - 1) as f64 * q) as usize];
        println!(
            "{:36} {:10.2} {:12.1}  ({:.1} to {:.1})",
            contender.name,
            own[own.len() / 2] / tests as f64 * 1e9,
            at(0.5),
            at(0.1),
            at(0.9)
        );
    }
}
