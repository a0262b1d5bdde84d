//! The golden file: what every mode answers on fixed scenes, bit for bit, at every level.
//!
//! A line is a scene, a mode and a query, how many answers are no miss, and a hash of all bits. Run with
//! `INTERTRI_GOLDEN=write` to write the file anew; CONTRIBUTING.md says when that is right.

mod common;

use std::fmt::Write;

use intertri::simd::Level;
use intertri::{Certified, Crossings, Double, Exact, Hit, Mode, Ray, Threshold, Triangle};
use intertri_lab::families::FAMILIES;
use intertri_lab::meshes::Mesh;
use intertri_lab::rng::Rng;
use intertri_trace::{Bvh, Place, Solid};

const FILE: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/golden/answers.txt");

/// FNV-1a over 64-bit words, and how many answers are no miss.
struct Digest {
    hash: u64,
    hits: u64,
}

impl Digest {
    fn new() -> Self {
        Self { hash: 0xcbf2_9ce4_8422_2325, hits: 0 }
    }

    fn word(&mut self, word: u64) {
        self.hash = (self.hash ^ word).wrapping_mul(0x0000_0100_0000_01b3);
    }

    /// A number; of a NaN nothing but that it is one is promised.
    fn number(&mut self, x: f64) {
        self.word(if x.is_nan() { f64::NAN.to_bits() } else { x.to_bits() });
    }

    fn hit(&mut self, hit: &Hit) {
        self.hits += u64::from(hit.is_hit());
        self.word(hit.triangle.into());
        for x in [hit.t, hit.u, hit.v] {
            self.number(x);
        }
    }
}

/// Triangles and rays by a name.
struct Scene {
    name: String,
    triangles: Vec<Triangle>,
    rays: Vec<Ray>,
    threshold: Threshold,
    /// Whether the triangles are a closed mesh.
    closed: bool,
}

/// Some triangles and rays of every family, and closed meshes with rays of one origin, to vertices and edges
/// among others.
fn scenes() -> Vec<Scene> {
    let mut scenes = vec![];
    for family in FAMILIES {
        let scene = common::scene(family, &mut Rng::new(11), 60, 40);
        let threshold = Threshold::new(scene.threshold).unwrap();
        let (triangles, rays) = (scene.triangles, scene.rays);
        scenes.push(Scene { name: family.name.into(), triangles, rays, threshold, closed: false });
    }
    for (name, mesh, eye) in [
        ("sphere", Mesh::icosphere(3), [0.25, 0.1, -0.3]),
        ("sphere from outside", Mesh::icosphere(2), [0.5, 3.0, -2.5]),
    ] {
        let vertices: Vec<[f32; 3]> = mesh.vertices.iter().map(|v| v.map(|x| x as f32)).collect();
        let triangles: Vec<Triangle> =
            mesh.faces.iter().map(|face| Triangle(face.map(|i| vertices[i]))).collect();
        let mut rng = Rng::new(12);
        let ray = |i: usize| {
            let [a, b, c] = triangles[i * 7 % triangles.len()].0;
            let at = match i % 4 {
                0 => a,
                1 => [0, 1, 2].map(|k| 0.5 * (a[k] + b[k])),
                2 => [0, 1, 2].map(|k| (a[k] + b[k] + c[k]) / 3.0),
                _ => rng.direction().map(|x| x as f32),
            };
            Ray::new(eye, [0, 1, 2].map(|k| at[k] - eye[k]))
        };
        let rays = (0..2048).map(ray).collect();
        let (name, threshold) = (name.into(), Threshold::DEFAULT);
        scenes.push(Scene { name, triangles, rays, threshold, closed: true });
    }
    scenes
}

/// The lines of a mode.
fn of_mode<M: Mode>(scene: &Scene, bvh: &Bvh, mode: &M, name: &str, lines: &mut String) {
    let Scene { triangles, rays, .. } = scene;
    let (mut hits, mut any) = (vec![Hit::MISS; rays.len()], vec![false; rays.len()]);
    let mut put = |query: &str, digest: &Digest| {
        let Digest { hash, hits } = digest;
        writeln!(lines, "{} | {name} | {query} | {hits} | {hash:#018x}", scene.name).unwrap();
    };

    let mut digest = Digest::new();
    bvh.closest_batch(mode, rays, &mut hits);
    for hit in &hits {
        digest.hit(hit);
    }
    put("closest, batch", &digest);

    let mut digest = Digest::new();
    let few = &rays[..rays.len().min(100)];
    for ray in few {
        digest.hit(&bvh.closest(mode, ray).unwrap_or(Hit::MISS));
    }
    put("closest, one", &digest);

    let mut digest = Digest::new();
    let slices = &mut hits[..few.len()];
    mode.closest_batch(triangles, few, slices);
    for hit in slices {
        digest.hit(hit);
    }
    put("closest, slices", &digest);

    let mut digest = Digest::new();
    bvh.any_batch(mode, rays, &mut any);
    for any in any {
        digest.word(any.into());
        digest.hits += u64::from(any);
    }
    put("any", &digest);

    let mut digest = Digest::new();
    for hit in few.iter().flat_map(|ray| bvh.all(mode, ray)) {
        digest.hit(&hit);
    }
    put("all", &digest);
}

/// The lines of crossings and of what is inside, by `exact`.
fn of_crossings(scene: &Scene, bvh: &Bvh, mode: Exact, lines: &mut String) {
    let Scene { name, triangles, rays, .. } = scene;
    let mut digest = Digest::new();
    let mut counts = vec![Crossings::default(); rays.len()];
    bvh.crossings_batch(&mode, rays, &mut counts);
    for (ray, count) in rays.iter().zip(&counts).take(100) {
        digest.word(count.signed as u64);
        for crossing in bvh.crossings(&mode, ray) {
            digest.hit(&crossing.hit);
            digest.word(crossing.leaves.into());
        }
    }
    let Digest { hash, hits } = digest;
    writeln!(lines, "{name} | exact | crossings | {hits} | {hash:#018x}").unwrap();
    if scene.closed {
        let solid = Solid::new(triangles).unwrap();
        let points = rays.iter().map(|ray| [0, 1, 2].map(|k| ray.origin[k] + 0.9 * ray.dir[k]));
        let points: Vec<[f32; 3]> = points.chain(triangles.iter().map(|t| t.0[0])).collect();
        let mut places = vec![Place::Outside; points.len()];
        solid.place_batch(&points, &mut places);
        let mut digest = Digest::new();
        for place in places {
            digest.hits += u64::from(place != Place::Outside);
            digest.word(match place {
                Place::Outside => 0,
                Place::Inside(times) => times as u64,
                Place::Surface => u64::MAX / 2,
            });
        }
        let Digest { hash, hits } = digest;
        writeln!(lines, "{name} | exact | contains | {hits} | {hash:#018x}").unwrap();
    }
}

#[test]
fn the_answers_are_golden_at_every_level() {
    let scenes = scenes();
    let answers = |level: Level| {
        let mut lines = String::new();
        for scene in &scenes {
            let bvh = Bvh::new(&scene.triangles).unwrap();
            let (certified, double) =
                (Certified::new(scene.threshold), Double::new(scene.threshold));
            of_mode(scene, &bvh, &certified.at(level), "certified", &mut lines);
            of_mode(scene, &bvh, &double.at(level), "double", &mut lines);
            of_mode(scene, &bvh, &Exact::at(level), "exact", &mut lines);
            of_crossings(scene, &bvh, Exact::at(level), &mut lines);
        }
        lines
    };
    if std::env::var_os("INTERTRI_GOLDEN").is_some() {
        std::fs::write(FILE, answers(Level::PORTABLE)).unwrap();
    }
    let golden = std::fs::read_to_string(FILE).unwrap();
    for level in Level::all() {
        let answers = answers(level);
        for (got, want) in answers.lines().zip(golden.lines()) {
            assert_eq!(got, want, "{}", level.name());
        }
        assert_eq!(answers.lines().count(), golden.lines().count(), "{}", level.name());
    }
}
