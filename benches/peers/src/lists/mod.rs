//! Measures queries that list every hit of each ray, sorted by t. Compares intertri's batches and
//! single-ray calls with Embree, in which a filter collects and rejects every hit, and with obvhs,
//! in which a closure does the same.

mod collected;
mod embree;
mod obvhs;
mod ours;

pub use collected::ListedHit;

use std::collections::HashMap;
use std::path::PathBuf;
use std::sync::Arc;

use clap::Args;
use intertri::simd::Level;
use intertri::{Mode, Ray, Triangle};
use intertri_trace::Bvh;
use rayon::prelude::*;

use crate::clock::Clock;
use crate::embree::{Api, Build, Scene};
use crate::engine::{Answer, Engine, Question};
use crate::engines::wanted_of;
use crate::measure::{self, Named, Row};
use crate::rays::{self, Kind, Order};
use crate::truth::Truth;
use crate::{report, scenes};

/// The measured engines, by name.
pub const ENGINES: [&str; 11] = [
    "certified-single",
    "exact-single",
    "certified",
    "exact",
    "embree-fast-1",
    "embree-fast-8",
    "embree-fast-16",
    "embree-robust-1",
    "embree-robust-8",
    "obvhs-2",
    "obvhs-8",
];

/// The kind of query: all hits, for rays that are not declared coherent.
const QUESTION: Question = Question { any: false, coherent: false };

#[derive(Args)]
pub struct Options {
    /// Scenes to trace; see the `rays` command.
    #[arg(long, value_delimiter = ',', default_value = "bunny,kitchen,sphere")]
    scene: Vec<String>,
    /// Kinds of rays to trace: primary or diffuse.
    #[arg(long, value_delimiter = ',', default_value = "primary,diffuse")]
    kind: Vec<Kind>,
    /// Engines to measure: names, or prefixes of names that end before a dash; all by default.
    #[arg(long, value_delimiter = ',')]
    engine: Vec<String>,
    /// Maximum number of hits to list for each ray; unlimited by default. Other tracers always list
    /// all.
    #[arg(long)]
    limit: Option<usize>,
    /// Number of threads; 0 uses all.
    #[arg(long, default_value_t = 1)]
    threads: usize,
    /// Seconds per engine, scene and kind of ray.
    #[arg(long, default_value_t = 1.0)]
    seconds: f64,
    /// Width and height of the image in pixels; a power of two.
    #[arg(long, default_value_t = 1024)]
    size: u32,
    /// File to write the figures to as JSON.
    #[arg(long)]
    json: Option<PathBuf>,
    /// Path to Embree's shared library; see the `rays` command.
    #[arg(long, env = "EMBREE")]
    embree: Option<PathBuf>,
}

pub fn run(options: &Options) -> Result<(), String> {
    if !options.size.is_power_of_two() || options.size > 1 << 14 {
        return Err("--size must be a power of two, at most 16384".into());
    }
    let (api, pool) = (crate::embree(options.embree.clone()), crate::pool(options.threads)?);
    report::header(pool.install(Clock::fastest), pool.current_num_threads(), options.size);
    let mut rows = Vec::new();
    for name in &options.scene {
        let scene = scenes::scene(name)?;
        let triangles = scene.mesh.to_triangles();
        let bvh = Arc::new(Bvh::new(&triangles).map_err(|e| e.to_string())?);
        let mut engines = engines(options, &scene, &triangles, &bvh, api.as_ref());
        for &kind in &options.kind {
            let rays = rays::rays(kind, &scene, &bvh, options.size, Order::Tiles);
            let truth = pool.install(|| truth(&bvh, &rays, options.limit));
            let hits: usize =
                truth.iter().filter(|a| a.is_hit()).map(|a| a.triangle as usize).sum();
            let seconds = options.seconds;
            let measured = measure::measure(
                &mut engines,
                &rays,
                QUESTION,
                &|_| Truth::without_ties(&truth),
                seconds,
                &pool,
                measure::embree,
            );
            let measured: Vec<Row> = measured
                .into_iter()
                .map(|row| Row {
                    scene: name.clone(),
                    triangles: triangles.len(),
                    kind: format!("{}, every hit", kind.name()),
                    order: Order::Tiles.name().into(),
                    threads: pool.current_num_threads(),
                    ..row
                })
                .collect();
            report::table(&measured);
            println!("{} hits", report::grouped(hits));
            rows.extend(measured);
        }
    }
    if let Some(path) = &options.json {
        let text = serde_json::to_string_pretty(&rows).map_err(|e| e.to_string())?;
        crate::write(path, text.as_bytes())?;
    }
    Ok(())
}

/// Returns the true number of hits of each ray, from `certified` at the portable level, tracing one
/// ray per call.
fn truth(bvh: &Bvh, rays: &[Ray], limit: Option<usize>) -> Vec<Answer> {
    let mode = Mode::certified().at(Level::PORTABLE);
    let count = |ray| bvh.query().mode(mode).all(ray).len().min(limit.unwrap_or(usize::MAX));
    rays.par_iter().map(|ray| answer(count(ray))).collect()
}

/// Returns an answer that stores the number of hits in place of a triangle index.
fn answer(hits: usize) -> Answer {
    if hits == 0 { Answer::MISS } else { Answer { triangle: hits as u32, t: f64::NAN } }
}

fn engines(
    options: &Options,
    scene: &intertri_scene::Scene,
    triangles: &[Triangle],
    bvh: &Arc<Bvh>,
    api: Option<&Arc<Api>>,
) -> Vec<Named> {
    let mut scenes = HashMap::new();
    let mut engines: Vec<Named> = Vec::new();
    for name in ENGINES {
        if !wanted_of(name, &options.engine, ENGINES.iter().copied()) {
            continue;
        }
        let engine: Option<Box<dyn Engine>> = match name {
            "certified" | "certified-single" => {
                Some(ours(name, bvh, Mode::certified(), options.limit))
            }
            "exact" | "exact-single" => Some(ours(name, bvh, Mode::exact(), options.limit)),
            "obvhs-2" | "obvhs-8" => {
                Some(Box::new(obvhs::Every::new(triangles, name == "obvhs-8")))
            }
            _ => api.and_then(|api| {
                let robust = name.contains("robust");
                let scene = scenes.entry(robust).or_insert_with(|| {
                    let build =
                        Build { robust, high: false, avx2: false, threads: 0, collect: true };
                    let scene =
                        Scene::new(api, &scene.mesh, build).inspect_err(|e| eprintln!("{e}"));
                    scene.ok().map(|scene| {
                        scene.commit();
                        Arc::new(scene)
                    })
                });
                let scene = scene.clone()?;
                Some(match name.rsplit('-').next() {
                    Some("1") => Box::new(embree::Every::<1>::new(scene)) as Box<dyn Engine>,
                    Some("8") => Box::new(embree::Every::<8>::new(scene)),
                    _ => Box::new(embree::Every::<16>::new(scene)),
                })
            }),
        };
        engines.extend(engine.map(|engine| (name.to_owned(), engine)));
    }
    engines
}

/// Returns an engine for one of our modes that traces batches or one ray per call.
fn ours(name: &str, bvh: &Arc<Bvh>, mode: Mode, limit: Option<usize>) -> Box<dyn Engine> {
    let bvh = bvh.clone();
    if name.ends_with("single") {
        Box::new(ours::Single::new(bvh, mode))
    } else {
        Box::new(ours::Batch::new(bvh, mode, limit))
    }
}
