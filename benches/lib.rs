//! Code that the benchmarks share: the workloads, and a table of time ratios between contenders
//! that take turns.

use std::time::Instant;

use intertri::{Ray, Triangle};
use intertri_lab::rng::Rng;

pub mod moller_trumbore;

/// The rays and triangles of a benchmark.
#[derive(Debug)]
pub struct Workload {
    /// The rays.
    pub rays: Vec<Ray>,
    /// The triangles.
    pub triangles: Vec<Triangle>,
}

/// Returns a random triangle. Along each axis, its corners are at most `size` away from a random
/// point in the cube from -1 to 1.
fn triangle(rng: &mut Rng, size: f64) -> Triangle {
    let centre = rng.cube();
    let mut corner = || {
        let away = rng.cube();
        [0, 1, 2].map(|k| (centre[k] + size * away[k]) as f32)
    };
    Triangle([corner(), corner(), corner()])
}

impl Workload {
    /// Returns rays with random origins in the cube from -1 to 1 and random directions, and
    /// triangles scattered over this cube. No two rays in a packet are similar, and about one test
    /// in fifty is a hit.
    pub fn strewn(rays: usize, triangles: usize) -> Self {
        let mut rng = Rng::new(8);
        let f32s = |v: [f64; 3]| v.map(|x| x as f32);
        let mut ray = || Ray::new(f32s(rng.cube()), f32s(rng.direction()));
        let rays = (0..rays).map(|_| ray()).collect();
        Self { rays, triangles: (0..triangles).map(|_| triangle(&mut rng, 0.4)).collect() }
    }

    /// Returns a camera's view of triangles scattered over a cube, with 4 × 2 pixels per packet.
    /// About one test in fifty is a hit. With `shared`, all rays start at one point; otherwise each
    /// has its own origin.
    ///
    /// # Panics
    /// Panics if `rays` is not a multiple of 8 or `triangles` is 0.
    pub fn view(rays: usize, triangles: usize, shared: bool) -> Self {
        assert!(rays.is_multiple_of(8) && triangles > 0);
        let mut rng = Rng::new(7);
        let f32s = |v: [f64; 3]| v.map(|x| x as f32);
        let across = ((rays as f64 / 8.0).sqrt().ceil() * 4.0) as usize;
        let ray = |i: usize, rng: &mut Rng| {
            let (packet, pixel) = (i / 8, i % 8);
            let column = packet * 4 % across + pixel % 4;
            let row = packet * 4 / across * 2 + pixel / 4;
            let target = [
                (column as f64 + 0.5) / across as f64 * 2.0 - 1.0,
                (row as f64 + 0.5) / (across / 2) as f64 * 2.0 - 1.0,
                0.0,
            ];
            let moved = if shared { [0.0; 3] } else { rng.cube() };
            let eye = [0.1, 0.2, -3.0];
            let origin = [0, 1, 2].map(|k| eye[k] + 0.02 * moved[k]);
            let dir = [0, 1, 2].map(|k| target[k] - origin[k]);
            let length = dir.iter().map(|x| x * x).sum::<f64>().sqrt();
            Ray::new(f32s(origin), f32s(dir.map(|x| x / length)))
        };
        Self {
            rays: (0..rays).map(|i| ray(i, &mut rng)).collect(),
            triangles: (0..triangles).map(|_| triangle(&mut rng, 0.4)).collect(),
        }
    }
}

/// A contender's answer: the number of hits, and a checksum of the triangles and all bits of t.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Answer {
    /// The number of rays that hit a triangle.
    pub hits: u64,
    /// The sum of the triangle indices and the bits of t.
    pub mixed: u64,
}

impl Answer {
    /// Adds the closest hit of a ray.
    #[inline(always)]
    pub fn add(&mut self, triangle: u64, t: f64) {
        self.hits += 1;
        self.mixed = self.mixed.wrapping_add(triangle).wrapping_add(t.to_bits());
    }
}

/// A contender: a name, a function, and whether its answer must equal the first contender's.
pub struct Contender<'a> {
    /// The name in the table.
    pub name: String,
    /// Runs all tests of the workload once.
    pub run: Box<dyn FnMut() -> Answer + 'a>,
    /// Whether its answer must equal the first contender's.
    pub exact: bool,
}

/// Runs the contenders round-robin, and prints the speed of each relative to the first.
///
/// Turns are short, so that a dip in the clock rate slows all contenders alike. A ratio is computed
/// for each turn, and the table shows the median with the tenth and ninetieth percentiles.
///
/// # Panics
/// Panics if the answer of an exact contender differs from that of the first contender.
pub fn compare(title: &str, tests: usize, turns: usize, contenders: &mut [Contender<'_>]) {
    let truth = (contenders[0].run)();
    let mut times = vec![vec![]; contenders.len()];
    for turn in 0..turns + 2 {
        for (contender, times) in contenders.iter_mut().zip(&mut times) {
            let start = Instant::now();
            let answer = std::hint::black_box((contender.run)());
            let time = start.elapsed().as_secs_f64();
            assert!(
                !contender.exact || answer == truth,
                "{}: {answer:?} {truth:?}",
                contender.name
            );
            // The first two turns are only a warm-up.
            if turn >= 2 {
                times.push(time);
            }
        }
    }
    println!("\n{title}: {tests} tests per turn, {} hits, {turns} alternating turns", truth.hits);
    println!("{:36} {:>10} {:>28}", "", "ns/test", "times the first");
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
