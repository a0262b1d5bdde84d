//! Benchmarks point classification and winding numbers on one thread, for a closed globe and for
//! globes whose holes have a hundred or a thousand open edges. Prints how many million points are
//! classified, and how many million winding numbers are computed, per second.
//!
//! ```sh
//! cargo bench -p intertri-benches --bench winding
//! ```

use std::time::Instant;

use intertri::{Triangle, TriangleOf};
use intertri_lab::rng::Rng;
use intertri_trace::Solid;
use intertri_trace::internal::on_this_thread;

/// The number of points to classify.
const POINTS: usize = 1_000_000;
/// The number of winding numbers to compute.
const NUMBERS: usize = 20_000;

/// Returns a globe with `rings` rings of triangles.
fn globe(rings: usize) -> Vec<Triangle> {
    let corner = |ring: usize, i: usize| {
        let (a, b) = (ring as f32 / rings as f32, (i % (2 * rings)) as f32 / (2 * rings) as f32);
        let (a, b) = (a * std::f32::consts::PI, b * std::f32::consts::TAU);
        let r = if ring == 0 || ring == rings { 0.0 } else { a.sin() };
        [r * b.cos(), a.cos(), r * b.sin()]
    };
    let squares = (0..2 * rings * rings).map(|k| (k / (2 * rings), k % (2 * rings)));
    let halves = |(ring, i)| {
        let [a, b] = [corner(ring, i), corner(ring, i + 1)];
        let [c, d] = [corner(ring + 1, i), corner(ring + 1, i + 1)];
        [TriangleOf([a, b, c]), TriangleOf([d, c, b])]
    };
    let has_area = |t: &Triangle| t.0[0] != t.0[1] && t.0[1] != t.0[2] && t.0[2] != t.0[0];
    squares.flat_map(halves).filter(has_area).collect()
}

/// Returns the whole globe, the globe without its top, and the globe without some of its faces.
fn meshes(rng: &mut Rng) -> Vec<(&'static str, Vec<Triangle>)> {
    let without_lid = |rings: usize| {
        let mut mesh = globe(rings);
        mesh.retain(|t| t.0.iter().any(|corner| corner[1] < 0.71));
        mesh
    };
    let mut with_holes = |one_in: usize| {
        let mut mesh = globe(100);
        mesh.retain(|_| !rng.one_in(one_in));
        mesh
    };
    vec![
        ("closed", globe(100)),
        ("one hole", without_lid(50)),
        ("one hole, finer", without_lid(500)),
        ("small holes", with_holes(1200)),
        ("more small holes", with_holes(120)),
    ]
}

fn main() {
    let mut rng = Rng::new(7);
    let points: Vec<[f32; 3]> = (0..POINTS).map(|_| rng.cube().map(|x| 1.2 * x as f32)).collect();
    let (mut inside, mut numbers) = (vec![false; POINTS], vec![None; NUMBERS]);
    println!(
        "{:>18} {:>10} {:>8} {:>12} {:>12}",
        "", "open edges", "inside", "Mpoints/s", "Mnumbers/s"
    );
    for (name, mesh) in meshes(&mut rng) {
        let solid = Solid::from_soup(&mesh).expect("the mesh is small enough");
        let mut best = [f64::INFINITY; 2];
        on_this_thread(|| {
            for _ in 0..3 {
                let began = Instant::now();
                solid.contains_batch_into(&points, &mut inside);
                best[0] = best[0].min(began.elapsed().as_secs_f64() / POINTS as f64);
                let began = Instant::now();
                solid.winding_number_batch_into(&points[..NUMBERS], &mut numbers);
                best[1] = best[1].min(began.elapsed().as_secs_f64() / NUMBERS as f64);
            }
        });
        let count = inside.iter().filter(|&&inside| inside).count();
        let [classified, number] = best.map(|seconds| 1e-6 / seconds);
        println!(
            "{name:>18} {:>10} {count:>8} {classified:>12.2} {number:>12.3}",
            solid.open_edges()
        );
    }
}
