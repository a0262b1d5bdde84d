//! Runs one kind of step repeatedly at the narrowest level, to count its instructions:
//!
//!     steps NAME TIMES
//!
//! The difference between the counts of two runs with different TIMES is the cost of the steps
//! alone; `docs/targets.md` lists it.

use std::hint::black_box;

use intertri::simd::Level;
use intertri::{Hit, Mode, Ray, Triangle};
use intertri_lab::meshes::Mesh;
use intertri_lab::rng::Rng;
use intertri_trace::Bvh;

const LEVEL: Level = Level::PORTABLE;

fn main() {
    let args: Vec<String> = std::env::args().collect();
    let times = args.get(2).and_then(|times| times.parse().ok());
    let (Some(name), Some(times)) = (args.get(1), times) else { panic!("give NAME TIMES") };
    let (certified, exact) = (Mode::certified().at(LEVEL), Mode::exact().at(LEVEL));
    let mut inputs = Inputs(Rng::new(1));
    match &name[..] {
        "slices certified" => slices(&mut inputs, certified, times),
        "slices exact" => slices(&mut inputs, exact, times),
        "primary certified" => batches(certified, &primary(), times),
        "primary exact" => batches(exact, &primary(), times),
        "scattered certified" => batches(certified, &inputs.scattered(), times),
        "scattered exact" => batches(exact, &inputs.scattered(), times),
        "one certified" => one_by_one(certified, &inputs.scattered(), times),
        "one exact" => one_by_one(exact, &inputs.scattered(), times),
        "any certified" => any(certified, &inputs.scattered(), times),
        _ => panic!("no step has the name {name}"),
    }
}

/// An endless supply of random points, triangles and rays.
struct Inputs(Rng);

impl Inputs {
    fn point(&mut self) -> [f32; 3] {
        self.0.direction().map(|x| x as f32)
    }
    fn triangles(&mut self) -> Vec<Triangle> {
        (0..64).map(|_| Triangle::new(self.point(), self.point(), self.point())).collect()
    }
    fn rays(&mut self) -> Vec<Ray> {
        (0..64).map(|_| Ray::new(self.point(), self.point())).collect()
    }
    /// Returns rays in all directions from inside a sphere.
    fn scattered(&mut self) -> Vec<Ray> {
        (0..4096).map(|_| Ray::new(self.point().map(|x| 0.3 * x), self.point())).collect()
    }
}

/// Returns the rays of a camera that sees a sphere, for 64×64 pixels.
fn primary() -> Vec<Ray> {
    let at = |i: i32| (i as f32 / 32.0 - 1.0) * 0.4;
    (0..4096).map(|i| Ray::new([0.1, 0.2, -3.0], [at(i % 64), at(i / 64), 1.0])).collect()
}

fn sphere() -> Bvh {
    let mesh = Mesh::icosphere(5);
    let vertices: Vec<[f32; 3]> = mesh.vertices.iter().map(|v| v.map(|x| x as f32)).collect();
    let face = |face: &[usize; 3]| Triangle(face.map(|i| vertices[i]));
    Bvh::new(&mesh.faces.iter().map(face).collect::<Vec<_>>()).expect("the scene is small enough")
}

/// Queries a slice for each ray: 4096 pairs.
fn slices(inputs: &mut Inputs, mode: Mode, times: u64) {
    let (triangles, rays) = (inputs.triangles(), inputs.rays());
    let mut hits = vec![Hit::MISS; rays.len()];
    for _ in 0..times {
        mode.closest_batch(black_box(&triangles), &rays, &mut hits);
        black_box(&hits);
    }
}

/// Traces a batch of 4096 rays through the hierarchy of a sphere.
fn batches(mode: Mode, rays: &[Ray], times: u64) {
    let (bvh, mut hits) = (sphere(), vec![Hit::MISS; rays.len()]);
    for _ in 0..times {
        bvh.query().mode(mode).closest_batch_into(black_box(rays), &mut hits);
        black_box(&hits);
    }
}

/// Like [`batches`], but with one ray per call.
fn one_by_one(mode: Mode, rays: &[Ray], times: u64) {
    let bvh = sphere();
    for _ in 0..times {
        for ray in rays {
            black_box(bvh.query().mode(mode).closest(black_box(ray)));
        }
    }
}

/// Like [`one_by_one`], but only determines whether there is a hit.
fn any(mode: Mode, rays: &[Ray], times: u64) {
    let bvh = sphere();
    for _ in 0..times {
        for ray in rays {
            black_box(bvh.query().mode(mode).any(black_box(ray)));
        }
    }
}
