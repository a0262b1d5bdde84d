//! Measures cliffs: how much longer the same rays take if a scene contains something that slows
//! tracers down.
//!
//! The obstacles include a stray triangle, distant origins, thin triangles, and rays aimed at
//! edges. Each engine traces each case and its plain counterpart. If a tracer's time depends only
//! on what the rays hit, its ratios are close to 1.

use std::path::PathBuf;
use std::sync::Arc;

use clap::Args;
use intertri::{Hit, Mode, Ray};
use intertri_scene::{Mesh, Scene, hit_point};
use intertri_trace::Bvh;
use rayon::ThreadPool;

use crate::embree::Api;
use crate::engine::{Engine, Question};
use crate::engines;
use crate::measure::{self, Row};
use crate::ours::Batch;
use crate::rays::{self, Kind, Order};
use crate::truth::Truth;
use crate::{embree, pool, report, scenes, write_rows};

/// The property that makes a scene hostile to tracers.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
pub enum Cause {
    /// One additional triangle, at increasing distances.
    Stray,
    /// One additional triangle, as in `Stray`, with diffuse rays.
    StrayDiffuse,
    /// Ray origins at increasing distances from the points that the camera sees.
    Origin,
    /// Increasingly thin triangles: a wavy plate with a constant number of triangles.
    Thin,
    /// An increasing share of rays aimed at edges.
    Edges,
    /// An increasing share of rays aimed at vertices.
    Vertices,
    /// A globe with quads at its poles. Half of the triangles of these quads are needles.
    Poles,
}

impl Cause {
    /// Returns the name of the cause in tables and files.
    pub fn name(self) -> &'static str {
        match self {
            Self::Stray => "stray",
            Self::StrayDiffuse => "stray-diffuse",
            Self::Origin => "origin",
            Self::Thin => "thin",
            Self::Edges => "edges",
            Self::Vertices => "vertices",
            Self::Poles => "poles",
        }
    }

    /// Returns the severities to try. The first is the plain case.
    fn amounts(self) -> &'static [f64] {
        match self {
            Self::Stray => &[0.0, 1e2, 1e4, 1e6, 1e8],
            Self::StrayDiffuse => &[0.0, 1e6],
            Self::Origin => &[0.0, 1e1, 1e2, 1e3, 1e4, 1e5],
            Self::Thin => &[1.0, 16.0, 256.0, 4096.0, 65536.0],
            Self::Edges | Self::Vertices => &[0.0, 0.01, 0.1, 0.5, 1.0],
            Self::Poles => &[0.0, 1.0],
        }
    }

    /// Returns whether the cause generates its own scene. All other causes use the scenes that the
    /// user chose.
    fn has_its_own_scene(self) -> bool {
        matches!(self, Self::Thin | Self::Poles)
    }

    fn what(self, amount: f64) -> String {
        match self {
            Self::Thin => format!("triangles {amount} times as long as wide"),
            _ if amount == 0.0 => "plain".into(),
            Self::Stray | Self::StrayDiffuse => format!("a stray triangle {amount} sizes away"),
            Self::Origin => format!("origins {amount} sizes away"),
            Self::Edges => format!("{} % of the rays aimed at edges", 100.0 * amount),
            Self::Vertices => format!("{} % of the rays aimed at vertices", 100.0 * amount),
            Self::Poles => "quads at the poles".into(),
        }
    }
}

#[derive(Args)]
pub struct Options {
    /// Scenes to trace; see the `rays` command.
    #[arg(long, value_delimiter = ',', default_value = "bunny,kitchen,sphere")]
    scene: Vec<String>,
    /// Properties that make the scenes hostile.
    #[arg(
        long,
        value_enum,
        value_delimiter = ',',
        default_value = "stray,stray-diffuse,origin,thin,edges,vertices,poles"
    )]
    cause: Vec<Cause>,
    /// Engines to measure; see the `rays` command.
    #[arg(
        long,
        value_delimiter = ',',
        default_value = "exact,exact-query,certified,embree-fast-1,embree-fast-16,embree-robust-16,obvhs-2"
    )]
    engine: Vec<String>,
    /// Seconds per engine, scene and kind of ray.
    #[arg(long, default_value_t = 0.5)]
    seconds: f64,
    /// Width and height of the image in pixels; a power of two.
    #[arg(long, default_value_t = 256)]
    size: u32,
    /// The order of the pixels.
    #[arg(long, value_enum, default_value_t = Order::Rows)]
    order: Order,
    /// File to write the figures to as JSON, for example for `chart`.
    #[arg(long)]
    json: Option<PathBuf>,
    /// Path to Embree's shared library; see the `rays` command.
    #[arg(long, env = "EMBREE")]
    embree: Option<PathBuf>,
}

/// A scene and the rays to trace in it.
struct Case {
    scene: Scene,
    rays: Vec<Ray>,
    question: Question,
}

pub fn run(options: &Options) -> Result<(), String> {
    let (api, pool) = (embree(options.embree.clone()), pool(1)?);
    println!("{}; one thread, {1} x {1} pixels", report::cpu(), options.size);
    let mut all = Vec::new();
    for &cause in &options.cause {
        let generated = [cause.name().to_owned()];
        let names = if cause.has_its_own_scene() { &generated[..] } else { &options.scene[..] };
        for name in names {
            let mut plain: Vec<Row> = Vec::new();
            for &amount in cause.amounts() {
                let case = case(options, name, cause, amount)?;
                let rows = measured(options, &case, api.as_ref(), &pool)?;
                let rows: Vec<Row> = rows
                    .into_iter()
                    .map(|row| {
                        let triangles = case.scene.mesh.triangles.len();
                        Row { amount, ..row.of(name, triangles, cause.name(), options.order) }
                    })
                    .collect();
                report::cliff(&format!("{name}: {}", cause.what(amount)), &rows, &plain);
                all.extend(rows.iter().cloned());
                if plain.is_empty() {
                    plain = rows;
                }
            }
        }
    }
    options.json.as_ref().map_or(Ok(()), |path| write_rows(path, &all))
}

/// Measures a case. Returns its rows, without the fields that describe the case.
fn measured(
    options: &Options,
    case: &Case,
    api: Option<&Arc<Api>>,
    pool: &ThreadPool,
) -> Result<Vec<Row>, String> {
    let triangles = case.scene.mesh.to_triangles();
    let bvh = Arc::new(Bvh::new(&triangles).map_err(|e| e.to_string())?);
    let mut named = engines::engines(&options.engine, &case.scene, &triangles, &bvh, api);
    let mut exact = Batch::new(bvh.clone(), Mode::exact());
    exact.load(&case.rays, case.question);
    exact.trace(0..case.rays.len());
    let (answers, rays) = (exact.answers(), &case.rays);
    let truth = |name: &str| Truth::new(name, &answers, &triangles, rays);
    let (seconds, none): (f64, measure::Beside) = (options.seconds, |_, _| None);
    Ok(measure::measure(&mut named, rays, case.question, &truth, seconds, pool, none))
}

fn case(options: &Options, name: &str, cause: Cause, amount: f64) -> Result<Case, String> {
    let (size, order) = (options.size, options.order);
    let generated = |mesh| Scene::of(mesh, 1.0).map_err(|e| e.to_string());
    let scene = match cause {
        Cause::Thin => generated(plate(amount.sqrt() as u32))?,
        Cause::Poles => generated(globe(256, 128, amount > 0.0))?,
        _ => scenes::scene(name)?,
    };
    let bvh = Bvh::new(&scene.mesh.to_triangles()).map_err(|e| e.to_string())?;
    let kind = if cause == Cause::StrayDiffuse { Kind::Diffuse } else { Kind::Primary };
    let mut rays = rays::rays(kind, &scene, &bvh, size, order);
    match cause {
        Cause::Origin if amount > 0.0 => rays = from_afar(&scene, &bvh, &rays, amount as f32),
        Cause::Edges | Cause::Vertices => {
            let target = if cause == Cause::Edges { Kind::Edges } else { Kind::Vertices };
            let aimed = rays::rays(target, &scene, &bvh, size, order);
            // Keep the camera rays that hit something; each has an aimed counterpart.
            let hits = bvh.query().mode(Mode::certified()).closest_batch(&rays);
            rays =
                rays.into_iter().zip(&hits).filter(|(_, hit)| hit.is_hit()).map(|x| x.0).collect();
            for (i, (ray, aimed)) in rays.iter_mut().zip(aimed).enumerate() {
                if scenes::random([i as u64, 3, 5]) < 2.0 * amount - 1.0 {
                    *ray = aimed;
                }
            }
        }
        _ => {}
    }
    let strays = matches!(cause, Cause::Stray | Cause::StrayDiffuse) && amount > 0.0;
    let scene = if strays { strayed(&scene, amount as f32) } else { scene };
    Ok(Case { scene, rays, question: kind.question() })
}

/// Returns the scene with one additional triangle, at a distance of `away` times the scene's size.
fn strayed(scene: &Scene, away: f32) -> Scene {
    let mut scene = scene.clone();
    let first = scene.mesh.positions.len() as u32;
    let (far, size) = (away * size(&scene.mesh), size(&scene.mesh));
    let corners = [[far, 0.0, 0.0], [far + size, 0.0, 0.0], [far, size, 0.0]];
    scene.mesh.positions.extend(corners);
    scene.mesh.triangles.push([first, first + 1, first + 2]);
    scene
}

/// Returns the length of the longest side of a mesh's bounding box.
fn size(mesh: &Mesh) -> f32 {
    mesh.bounds().map_or(1.0, |b| (0..3).map(|k| b.max[k] - b.min[k]).fold(0.0, f32::max))
}

/// Returns rays toward the points that the camera sees, from far behind the camera.
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

/// Returns a wavy plate of 2^17 triangles, each `length^2` times as long as it is wide.
fn plate(length: u32) -> Mesh {
    let (across, along) = (256 * length, 256 / length);
    let mut mesh = Mesh::default();
    for j in 0..=along {
        for i in 0..=across {
            let [x, y] = [i as f32 / across as f32, j as f32 / along as f32];
            mesh.positions.push([x, y, 0.05 * (20.0 * x).sin()]);
        }
    }
    for j in 0..along {
        for i in 0..across {
            let a = i + j * (across + 1);
            let above = a + across + 1;
            mesh.triangles.extend([[a, a + 1, above + 1], [a, above + 1, above]]);
        }
    }
    mesh
}

/// Returns a sphere made of meridians and parallels, computed in f32 as in most programs.
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
