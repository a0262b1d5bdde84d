//! Benchmarks a field of globes, which are instances of one mesh, on a single thread. Measures
//! primary, shadow and diffuse rays in the scene of instances and, for the smaller field, in the
//! flattened scene. Also measures commits after all instances have moved.
//!
//! ```sh
//! cargo bench -p intertri-benches --bench instances
//! ```

use std::hint::black_box;
use std::sync::Arc;
use std::time::Instant;

use intertri::{Ray64, Triangle, Triangle64};
use intertri_lab::rng::Rng;
use intertri_trace::internal::on_this_thread;
use intertri_trace::{Bvh, InstanceId, Scene, SceneSnapshot};

/// The width and height of the image in pixels.
const SIDE: usize = 400;

/// Returns a globe with `rings` rings of triangles.
fn globe(rings: usize) -> Vec<Triangle> {
    let corner = |ring: usize, i: usize| {
        let (a, b) = (ring as f32 / rings as f32, (i % (2 * rings)) as f32 / (2 * rings) as f32);
        let (a, b) = (a * std::f32::consts::PI, b * std::f32::consts::TAU);
        let r = if ring == 0 || ring == rings { 0.0 } else { a.sin() };
        [r * b.cos(), a.cos(), r * b.sin()]
    };
    let squares = (0..2 * rings * rings).map(|k| (k / (2 * rings), k % (2 * rings)));
    let halves = squares.flat_map(|(ring, i)| {
        let [a, b] = [corner(ring, i), corner(ring, i + 1)];
        let [c, d] = [corner(ring + 1, i), corner(ring + 1, i + 1)];
        [Triangle([a, b, c]), Triangle([d, c, b])]
    });
    halves.collect()
}

/// Returns the matrix that places globe `i` in a field of `side * side` globes, with its own
/// rotation and size.
fn placement(i: usize, side: usize, rng: &mut Rng) -> [f64; 12] {
    let ([a, b, _], [x, z]) = (rng.cube(), [i % side, i / side].map(|k| 2.5 * k as f64));
    let ((s, c), (p, q)) = ((3.0 * a).sin_cos(), (3.0 * b).sin_cos());
    let size = 0.8 + 0.3 * rng.cube()[0];
    let turned =
        [[c, -s, 0.0], [s * q, c * q, -p], [s * p, c * p, q]].map(|row| row.map(|m| size * m));
    let [[m0, m1, m2], [m4, m5, m6], [m8, m9, m10]] = turned;
    [m0, m1, m2, x, m4, m5, m6, 0.0, m8, m9, m10, z]
}

/// Returns the shortest of three measured times, in seconds.
fn seconds(mut work: impl FnMut()) -> f64 {
    let time = |_| {
        let start = Instant::now();
        work();
        start.elapsed().as_secs_f64()
    };
    (0..3).map(time).fold(f64::INFINITY, f64::min)
}

/// Creates camera rays from above the field. From each hit point, adds a shadow ray to a light and
/// a diffuse ray in a random direction.
fn rays(scene: &SceneSnapshot, side: usize, rng: &mut Rng) -> [Vec<Ray64>; 3] {
    let width = 2.5 * side as f64;
    let eye = [0.5 * width, 8.0, -6.0];
    let pixel = |i: usize| {
        let [x, y] = [i % SIDE, i / SIDE].map(|k| k as f64 / SIDE as f64 - 0.5);
        Ray64::new(eye, [1.6 * x, -0.4 - y, 1.0])
    };
    let primary: Vec<Ray64> = (0..SIDE * SIDE).map(pixel).collect();
    let (mut shadow, mut diffuse) = (Vec::new(), Vec::new());
    for (ray, hit) in primary.iter().zip(scene.closest_batch(&primary)) {
        if hit.is_hit() {
            let point = hit.hit.point(ray);
            let from = [0, 1, 2].map(|k| point[k] - 1e-6 * ray.dir[k]);
            let light = [0.3 * width, 30.0, 0.2 * width];
            shadow.push(Ray64::new(from, [0, 1, 2].map(|k| light[k] - from[k])).between(0.0, 1.0));
            diffuse.push(Ray64::new(from, rng.cube()));
        }
    }
    [primary, shadow, diffuse]
}

/// Prints a row of the table, in millions of rays per second.
fn row(name: &str, count: usize, seconds: [f64; 3], note: &str) {
    let [primary, shadow, diffuse] = seconds.map(|seconds| count as f64 / seconds * 1e-6);
    println!("{name:28} {primary:8.2} {shadow:8.2} {diffuse:8.2}   {note}");
}

fn field(mesh: &[Triangle], side: usize, is_flattened: bool) {
    let mut rng = Rng::new(5);
    let bvh = Arc::new(Bvh::new(mesh).expect("not enough memory to build the hierarchy"));
    let mut scene = Scene::new();
    let mut flat = Vec::new();
    for i in 0..side * side {
        let m = placement(i, side, &mut rng);
        scene.add(bvh.clone(), m).expect("the matrix is finite");
        let place = |[x, y, z]: [f64; 3]| {
            [0, 4, 8].map(|i| ((m[i] * x + m[i + 1] * y) + m[i + 2] * z) + m[i + 3])
        };
        if is_flattened {
            flat.extend(mesh.iter().map(|t| Triangle64(t.0.map(|c| place(c.map(f64::from))))));
        }
    }
    let scene = scene.commit().expect("not enough memory to commit the scene");
    let [primary, shadow, diffuse] = rays(&scene, side, &mut rng);
    println!("\n{} instances of {} triangles; million rays per second", side * side, mesh.len());
    println!("{:28} {:>8} {:>8} {:>8}", "", "primary", "shadow", "diffuse");
    let closest = |rays: &[Ray64]| seconds(|| drop(black_box(scene.closest_batch(rays))));
    let any = |rays: &[Ray64]| seconds(|| drop(black_box(scene.any_batch(rays))));
    let count = primary.len() as f64;
    let of = |rays: &[Ray64], seconds: f64| seconds * count / rays.len() as f64;
    let times = [closest(&primary), of(&shadow, any(&shadow)), of(&diffuse, closest(&diffuse))];
    row("instances", primary.len(), times, "");
    if is_flattened {
        let flat = Bvh::new(&flat).expect("not enough memory to build the flattened scene");
        let mut query = flat.query();
        let mut one_by_one = |rays: &[Ray64], any: bool| {
            seconds(|| {
                for ray in rays {
                    if any {
                        black_box(query.any(ray));
                    } else {
                        black_box(query.closest(ray));
                    }
                }
            })
        };
        let single = [
            one_by_one(&primary, false),
            of(&shadow, one_by_one(&shadow, true)),
            of(&diffuse, one_by_one(&diffuse, false)),
        ];
        row("flattened, one ray per call", primary.len(), single, "");
        let batch = [
            seconds(|| drop(black_box(flat.closest_batch(&primary)))),
            of(&shadow, seconds(|| drop(black_box(flat.any_batch(&shadow))))),
            of(&diffuse, seconds(|| drop(black_box(flat.closest_batch(&diffuse))))),
        ];
        row("flattened, a batch", primary.len(), batch, "");
    }
}

/// Measures commits after all instances have moved.
fn commits(mesh: &[Triangle], side: usize) {
    let bvh = Bvh::new(mesh).expect("not enough memory to build the hierarchy");
    let (mut rng, bvh) = (Rng::new(6), Arc::new(bvh));
    let mut scene = Scene::new();
    let ids: Vec<InstanceId> = (0..side * side)
        .map(|i| {
            scene.add(bvh.clone(), placement(i, side, &mut rng)).expect("the matrix is finite")
        })
        .collect();
    let mut best = f64::INFINITY;
    for _ in 0..5 {
        for (i, &id) in ids.iter().enumerate() {
            scene.place(id, placement(i, side, &mut rng)).expect("the instance exists");
        }
        let start = Instant::now();
        let snapshot = scene.commit().expect("not enough memory to commit the scene");
        best = best.min(start.elapsed().as_secs_f64());
        black_box(snapshot);
    }
    println!("commit of {} moved instances: {:.2} ms", ids.len(), best * 1e3);
}

fn main() {
    on_this_thread(|| {
        let mesh = globe(30);
        field(&mesh, 20, true);
        field(&mesh, 100, false);
        println!();
        commits(&mesh, 100);
        commits(&mesh, 1000);
    });
}
