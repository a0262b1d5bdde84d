//! Measures the share of wrong answers for walls far from the coordinate origin, for coordinates as
//! given and for coordinates rounded to f32.
//!
//! ```text
//!   f64 ──┬──► as given ─────────► exact, Möller–Trumbore f64
//!         ├──► rounded to f32 ───► exact, Möller–Trumbore f64, f32, Embree's forms
//!         └──► rationals ────────► the true answers
//! ```

use intertri::simd::{Level, Mask, Vec3};
use intertri::{Ray, Ray64, Triangle, Triangle64};
use rayon::prelude::*;
use serde::Serialize;

use crate::methods::moller_trumbore::MollerTrumbore;
use crate::methods::{Intersector, METHODS};
use crate::oracle::rational;
use crate::rng::Rng;
use crate::test_batch::Answer;

/// The precision of a method's input.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
pub enum InputPrecision {
    /// The coordinates as given, in f64.
    #[serde(rename = "f64")]
    AsGiven,
    /// The coordinates rounded to f32.
    #[serde(rename = "rounded to f32")]
    Rounded,
}

/// The methods to test, each with the precision of its input.
pub const CONTENDERS: [(&str, InputPrecision); 8] = [
    ("exact", InputPrecision::AsGiven),
    ("Möller–Trumbore f64", InputPrecision::AsGiven),
    ("exact", InputPrecision::Rounded),
    ("Möller–Trumbore f64", InputPrecision::Rounded),
    ("Möller–Trumbore f32", InputPrecision::Rounded),
    ("Woop f32", InputPrecision::Rounded),
    ("Embree fast f32", InputPrecision::Rounded),
    ("Embree robust f32", InputPrecision::Rounded),
];

/// A method's results for walls at one distance from the coordinate origin.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct OffsetErrors {
    /// The distance of the walls from the coordinate origin, in metres.
    pub distance: f64,
    /// The method.
    pub method: &'static str,
    /// The precision of the method's input.
    pub given: InputPrecision,
    /// The number of rays.
    pub trials: u64,
    /// The number of rays that hit the wall but are reported as misses.
    pub false_misses: u64,
    /// The number of rays that miss the wall but are reported as hits.
    pub false_hits: u64,
}

impl OffsetErrors {
    /// Returns the share of wrong answers.
    pub fn share(&self) -> f64 {
        (self.false_misses + self.false_hits) as f64 / self.trials.max(1) as f64
    }
}

/// The distances of the nearest and the farthest wall from the coordinate origin, in metres.
pub const DISTANCES: [f64; 2] = [1.0, 1e9];

/// The number of rays per wall.
const RAYS: u64 = 200;

/// A wall made of two triangles, and rays that start close to it.
struct Wall {
    halves: [Triangle64; 2],
    rays: Vec<Ray64>,
}

/// Tests the methods in [`CONTENDERS`] on 4 m × 3 m walls at random angles, at `points` logarithmically
/// spaced distances from the coordinate origin. At each distance, at least `cases` rays start 1 nm
/// to 10 cm from a wall, on either side, and go toward it or away from it. A quarter of them pass
/// through the diagonal where the wall's halves meet.
///
/// `exact` returns whether each ray hits the wall according to the `exact` mode; the true answers
/// come from rationals. The counts depend only on the seed, `points`, and `cases`.
pub fn sweep_offsets(
    seed: u64,
    points: usize,
    cases: u64,
    exact: &(impl Fn(&[Triangle64], &[Ray64]) -> Vec<bool> + Sync),
) -> Vec<OffsetErrors> {
    let at = |k: usize| {
        let share = k as f64 / (points - 1).max(1) as f64;
        // `between` uses only square roots, so the distance has the same bits on every machine.
        let distance = super::sweeps::between(DISTANCES[0], DISTANCES[1], share);
        let mut rng = Rng::new(seed ^ (k as u64) << 32);
        let mut errors = CONTENDERS.map(|(method, given)| OffsetErrors {
            distance,
            method,
            given,
            trials: 0,
            false_misses: 0,
            false_hits: 0,
        });
        for _ in 0..cases.div_ceil(RAYS) {
            let wall = wall(&mut rng, distance);
            let truth: Vec<bool> = wall.rays.iter().map(|ray| is_hit(&wall, ray)).collect();
            for errors in &mut errors {
                let answers = match (errors.given, errors.method) {
                    (InputPrecision::AsGiven, "exact") => exact(&wall.halves, &wall.rays),
                    (InputPrecision::AsGiven, _) => in_f64(&wall),
                    (InputPrecision::Rounded, name) => rounded(&wall, name),
                };
                assert_eq!(answers.len(), truth.len(), "each ray must have an answer");
                for (&truth, answer) in truth.iter().zip(answers) {
                    errors.trials += 1;
                    errors.false_misses += u64::from(truth && !answer);
                    errors.false_hits += u64::from(!truth && answer);
                }
            }
        }
        errors
    };
    (0..points).into_par_iter().flat_map_iter(at).collect()
}

/// Creates a random wall at a given distance from the coordinate origin.
fn wall(rng: &mut Rng, distance: f64) -> Wall {
    let along = |p: [f64; 3], v: [f64; 3], by: f64| [0, 1, 2].map(|k| p[k] + by * v[k]);
    let cross =
        |[a, b, c]: [f64; 3], [x, y, z]: [f64; 3]| [b * z - c * y, c * x - a * z, a * y - b * x];
    let unit = |v: [f64; 3]| {
        let length = v.iter().map(|x| x * x).sum::<f64>().sqrt();
        v.map(|x| x / length)
    };
    let corner = rng.direction().map(|x| x * distance);
    let normal = rng.direction();
    let right = unit(cross(normal, rng.direction()));
    let up = cross(right, normal);
    let at = |x: f64, y: f64| along(along(corner, right, x), up, y);
    let [a, b, c, d] = [at(0.0, 0.0), at(4.0, 0.0), at(4.0, 3.0), at(0.0, 3.0)];
    let ray = |_| {
        let (x, y) = (rng.unit(), rng.unit());
        let x = if rng.one_in(4) { y } else { x };
        let side = if rng.one_in(2) { 1.0 } else { -1.0 };
        let way = if rng.one_in(2) { 1.0 } else { -1.0 };
        let off = side * rng.log(1e-9, 0.1);
        let slant = along([0.0; 3], right, rng.signed());
        let dir = along(along(slant, up, rng.signed()), normal, way);
        // Place the origin relative to the point where the ray meets the wall's plane.
        let origin = along(at(4.0 * x, 3.0 * y), dir, off * way);
        Ray64::new(origin, dir)
    };
    let rays = (0..RAYS).map(ray).collect();
    Wall { halves: [Triangle64([a, b, c]), Triangle64([a, c, d])], rays }
}

/// Returns whether a ray hits a wall, computed in rationals.
fn is_hit(wall: &Wall, ray: &Ray64) -> bool {
    wall.halves.iter().any(|half| rational::answer(half, ray).is_hit())
}

/// Runs the Möller–Trumbore test in f64 on the coordinates as given.
fn in_f64(wall: &Wall) -> Vec<bool> {
    let method = MollerTrumbore { epsilon: 0.0 };
    let halves = wall.halves.map(|half| method.triangle::<f64>(half.0.map(Vec3::splat)));
    let hits = |ray: &Ray64| {
        let ray = method.ray::<f64>(Vec3::splat(ray.origin), Vec3::splat(ray.dir));
        halves.iter().any(|half| method.test(half, &ray).0.any())
    };
    wall.rays.iter().map(hits).collect()
}

/// Runs a method from the table on coordinates rounded to f32.
fn rounded(wall: &Wall, name: &str) -> Vec<bool> {
    let single = |p: [f64; 3]| p.map(|x| x as f32);
    let rays: Vec<Ray> =
        wall.rays.iter().map(|ray| Ray::new(single(ray.origin), single(ray.dir))).collect();
    let mut hits = vec![false; rays.len()];
    let mut to = vec![Answer::default(); rays.len()];
    let Some(method) = METHODS.iter().find(|method| method.name == name) else { return hits };
    for half in wall.halves {
        let triangles = vec![Triangle(half.0.map(single)); rays.len()];
        method.pairs(Level::best(), 0.0, &triangles, &rays, &mut to);
        hits.iter_mut().zip(&to).for_each(|(hit, answer)| *hit |= answer.hit);
    }
    hits
}
