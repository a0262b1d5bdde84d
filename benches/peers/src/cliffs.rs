//! Cliffs: how many times longer the same rays take if a scene contains something that slows tracers down.
//!
//! A stray triangle far away, a far origin, needles at the poles of a sphere: each engine traces each case
//! and its plain counterpart. A tracer whose time depends on what the rays meet has ratios near 1.

use std::path::PathBuf;
use std::sync::Arc;

use clap::Args;
use intertri::{Hit, Mode, Ray};
use intertri_scene::{Mesh, Scene, hit_point};
use intertri_trace::Bvh;

use crate::engine::{Answer, Engine, Question};
use crate::engines;
use crate::measure::{self, Row, Truth};
use crate::ours::Batch;
use crate::rays::{self, Kind, Order};
use crate::{embree, pool, report, scenes};

#[derive(Args)]
pub struct Options {
    /// Scenes, as for `rays`.
    #[arg(long, value_delimiter = ',', default_value = "bunny,kitchen,sphere")]
    scene: Vec<String>,
    /// Engines, as for `rays`.
    #[arg(
        long,
        value_delimiter = ',',
        default_value = "exact,exact-query,certified,embree-fast-1,embree-fast-16,embree-robust-16,obvhs-2"
    )]
    engine: Vec<String>,
    /// Seconds for each engine, scene and kind.
    #[arg(long, default_value_t = 0.5)]
    seconds: f64,
    /// Pixels along a side of the picture, a power of two.
    #[arg(long, default_value_t = 256)]
    size: u32,
    /// Embree's shared library, as for `rays`.
    #[arg(long, env = "EMBREE")]
    embree: Option<PathBuf>,
}

/// A scene and rays at it.
struct Case {
    what: String,
    scene: Scene,
    rays: Vec<Ray>,
    question: Question,
}

pub fn run(options: &Options) -> Result<(), String> {
    let (api, pool) = (embree(options.embree.clone()), pool(1)?);
    println!("{}; one thread, {1} x {1} pixels", report::cpu(), options.size);
    for plain_and_hostile in groups(options)? {
        let mut plain: Vec<Row> = Vec::new();
        for case in plain_and_hostile {
            let triangles = case.scene.mesh.to_triangles();
            let bvh = Arc::new(Bvh::new(&triangles).map_err(|e| e.to_string())?);
            let wanted = &options.engine;
            let mut named = engines::engines(wanted, &case.scene, &triangles, &bvh, api.as_ref());
            let mut exact = Batch::new(bvh.clone(), Mode::exact());
            exact.load(&case.rays, case.question);
            exact.trace(0..case.rays.len());
            let truth: Vec<Answer> = exact.answers();
            let (truth, none): (Truth<'_>, measure::Beside) = (&|_| &truth[..], |_, _| None);
            let (rays, seconds) = (&case.rays, options.seconds);
            let rows =
                measure::measure(&mut named, rays, case.question, truth, seconds, &pool, none);
            report::cliff(&case.what, &rows, &plain);
            if plain.is_empty() {
                plain = rows;
            }
        }
    }
    Ok(())
}

/// Plain cases, each followed by its hostile variants.
fn groups(options: &Options) -> Result<Vec<Vec<Case>>, String> {
    let mut groups = Vec::new();
    for name in &options.scene {
        let scene = scenes::scene(name)?;
        let bvh = Bvh::new(&scene.mesh.to_triangles()).map_err(|e| e.to_string())?;
        for kind in [Kind::Primary, Kind::Diffuse] {
            let rays = rays::rays(kind, &scene, &bvh, options.size, Order::Tiles);
            let case = |what: &str, scene: Scene, rays: Vec<Ray>| Case {
                what: format!("{name}, {}: {what}", kind.name()),
                scene,
                rays,
                question: kind.question(),
            };
            let mut group = vec![case("plain", scene.clone(), rays.clone())];
            group.push(case("a stray triangle 10^6 sizes away", strayed(&scene), rays.clone()));
            if kind == Kind::Primary {
                for far in [1e3, 1e4] {
                    let rays = from_afar(&scene, &bvh, &rays, far);
                    group.push(case(&format!("origins {far} sizes away"), scene.clone(), rays));
                }
            }
            groups.push(group);
        }
    }
    groups.push(poles(options)?);
    Ok(groups)
}

/// The scene with one more triangle, a million times its size away.
fn strayed(scene: &Scene) -> Scene {
    let mut scene = scene.clone();
    let first = scene.mesh.positions.len() as u32;
    let (far, size) = (1e6 * size(&scene.mesh), size(&scene.mesh));
    let corners = [[far, 0.0, 0.0], [far + size, 0.0, 0.0], [far, size, 0.0]];
    scene.mesh.positions.extend(corners);
    scene.mesh.triangles.push([first, first + 1, first + 2]);
    scene
}

/// The largest side of the box around a mesh.
fn size(mesh: &Mesh) -> f32 {
    mesh.bounds().map_or(1.0, |b| (0..3).map(|k| b.max[k] - b.min[k]).fold(0.0, f32::max))
}

/// Rays toward what the camera sees, from far behind the camera.
fn from_afar(scene: &Scene, bvh: &Bvh, rays: &[Ray], far: f32) -> Vec<Ray> {
    let mut hits = vec![Hit::MISS; rays.len()];
    bvh.query().closest_batch_into(rays, &mut hits);
    let (seen, away) =
        (rays.iter().zip(&hits).filter(|(_, hit)| hit.is_hit()), far * size(&scene.mesh));
    seen.map(|(ray, hit)| {
        let [at, d] = [hit_point(ray, hit).map(|x| x as f32), ray.dir];
        let length = d.iter().map(|x| x * x).sum::<f32>().sqrt();
        let origin = [0, 1, 2].map(|k| at[k] - d[k] / length * away);
        Ray::new(origin, [0, 1, 2].map(|k| at[k] - origin[k]))
    })
    .collect()
}

/// A globe whose poles are triangles, and one whose poles are quads, half of which are needles.
fn poles(options: &Options) -> Result<Vec<Case>, String> {
    let mut cases = Vec::new();
    for (what, quads) in [("plain", false), ("quads at the poles", true)] {
        let scene = Scene::of(globe(256, 128, quads), 1.0).map_err(|e| e.to_string())?;
        let rays = |i: u32| {
            scene.camera.ray(i % options.size, i / options.size, options.size, options.size)
        };
        let rays = (0..options.size * options.size).map(rays).collect();
        let (what, question) = (format!("globe, primary: {what}"), Kind::Primary.question());
        cases.push(Case { what, scene, rays, question });
    }
    Ok(cases)
}

/// A sphere of meridians and parallels, computed in f32 as most programs do it.
fn globe(meridians: u32, parallels: u32, quads: bool) -> Mesh {
    let mut mesh = Mesh::default();
    for j in 0..=parallels {
        let up = (0.5 - j as f32 / parallels as f32) * std::f32::consts::PI;
        for i in 0..=meridians {
            let around = i as f32 / meridians as f32 * std::f32::consts::TAU;
            mesh.positions.push([up.cos() * around.sin(), up.sin(), up.cos() * around.cos()]);
        }
    }
    for j in 0..parallels {
        for i in 0..meridians {
            let a = i + j * (meridians + 1);
            let below = a + meridians + 1;
            if j > 0 || quads {
                mesh.triangles.push([a, below, a + 1]);
            }
            if j + 1 < parallels || quads {
                mesh.triangles.push([a + 1, below, below + 1]);
            }
        }
    }
    mesh
}
