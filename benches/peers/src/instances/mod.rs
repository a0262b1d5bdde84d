//! Compares scenes of instances with the same scenes flattened and with Embree's instances.

mod forest;
mod ours;

use std::path::PathBuf;
use std::sync::Arc;
use std::time::Instant;

use intertri::Ray;
use intertri_trace::{Bvh, InstanceId, Scene, SceneSnapshot};
use rayon::ThreadPool;

use crate::clock::Clock;
use crate::embree::{self, Api, Build};
use crate::engine::{Answer, Engine};
use crate::in_f64::own::Own;
use crate::measure::{self, Named, Row};
use crate::ours::{Batch, Single};
use crate::rays::{Kind, Order, widened};
use crate::report;
use crate::truth::Truth;
use forest::Forest;
use ours::{Instances, InstancesSingle};

#[derive(clap::Args)]
pub struct Options {
    /// Scenes to trace: `kitchen`, or `bunnies-N` with N bunnies.
    #[arg(long, value_delimiter = ',', default_value = "kitchen,bunnies-100,bunnies-10000")]
    scene: Vec<String>,
    /// Kinds of rays to trace.
    #[arg(long, value_delimiter = ',', default_value = "primary,shadow,diffuse")]
    kind: Vec<Kind>,
    /// Names of the engines to measure; all by default.
    #[arg(long, value_delimiter = ',')]
    engine: Vec<String>,
    /// Numbers of instances to move before a commit.
    #[arg(long, value_delimiter = ',', default_value = "10000,1000000")]
    commit: Vec<usize>,
    /// Flatten only scenes with at most this many triangles.
    #[arg(long, default_value_t = 10_000_000)]
    flattened: usize,
    /// Number of threads; 0 uses all.
    #[arg(long, default_value_t = 1)]
    threads: usize,
    /// Seconds per engine, scene and kind of ray.
    #[arg(long, default_value_t = 1.0)]
    seconds: f64,
    /// Width and height of the image in pixels; a power of two.
    #[arg(long, default_value_t = 512)]
    size: u32,
    /// Order of the pixels.
    #[arg(long, value_enum, default_value_t = Order::Rows)]
    order: Order,
    /// Path to Embree's shared library; see the `rays` command.
    #[arg(long, env = "EMBREE")]
    embree: Option<PathBuf>,
}

pub fn run(options: &Options) -> Result<(), String> {
    let (api, pool) = (crate::embree(options.embree.clone()), crate::pool(options.threads)?);
    report::header(pool.install(Clock::fastest), pool.current_num_threads(), options.size);
    for name in &options.scene {
        rays_of(options, &Forest::by_name(name)?, name, api.as_ref(), &pool)?;
    }
    for &count in &options.commit {
        pool.install(|| commits(count, api.as_ref(), pool.current_num_threads()))?;
    }
    Ok(())
}

/// Builds and commits the scene of a forest. Returns the scene, its instances, and the snapshot.
fn committed(forest: &Forest) -> Result<(Scene, Vec<InstanceId>, SceneSnapshot), String> {
    let meshes = forest.meshes.iter().map(|mesh| Bvh::new(&mesh.to_triangles()).map(Arc::new));
    let meshes: Vec<_> = meshes.collect::<Result<_, _>>().map_err(|e| e.to_string())?;
    let mut scene = Scene::new();
    let add = |&(mesh, matrix): &(usize, _)| scene.add(meshes[mesh].clone(), matrix);
    let ids = forest.placed.iter().map(add).collect::<Result<_, _>>();
    let ids = ids.map_err(|e| e.to_string())?;
    let snapshot = scene.commit().map_err(|e| e.to_string())?;
    Ok((scene, ids, snapshot))
}

fn rays_of(
    options: &Options,
    forest: &Forest,
    name: &str,
    api: Option<&Arc<Api>>,
    pool: &ThreadPool,
) -> Result<(), String> {
    let wanted =
        |name: &str| options.engine.is_empty() || options.engine.iter().any(|only| only == name);
    let (_scene, _, snapshot) = committed(forest)?;
    let flat = wanted("flattened") || wanted("flattened-single");
    let flat = if flat && forest.triangles() <= options.flattened {
        Some(Arc::new(Bvh::new(&forest.flattened()).map_err(|e| e.to_string())?))
    } else {
        None
    };
    let build = Build { robust: false, high: false, avx2: false, threads: 0, collect: false };
    let embree = match api.filter(|_| wanted("embree-fast-1") || wanted("embree-fast-16")) {
        Some(api) => {
            let made = embree::Scene::of_instances(api, &forest.meshes, &forest.placed, build);
            Some(Arc::new(made?))
        }
        None => None,
    };
    for &kind in &options.kind {
        let rays = forest.rays(kind, &snapshot, options.size, options.order)?;
        let own: Arc<[_]> = rays.iter().map(widened).collect();
        let firsts = &forest.firsts;
        let ours = Instances::new(snapshot.clone(), firsts.clone());
        let single = InstancesSingle::new(snapshot.clone(), firsts.clone());
        let mut engines: Vec<Named> = vec![
            ("instances".into(), Box::new(Own::new(ours, &own))),
            ("instances-single".into(), Box::new(Own::new(single, &own))),
        ];
        if let Some(flat) = &flat {
            let mode = intertri::Mode::exact();
            let batch = Own::new(Batch::new(flat.clone(), mode), &own);
            let single = Own::new(Single::new(flat.clone(), mode), &own);
            engines.push(("flattened".into(), Box::new(batch)));
            engines.push(("flattened-single".into(), Box::new(single)));
        }
        if let Some(scene) = &embree {
            let one = embree::Instances::<1>::new(scene.clone(), firsts.clone());
            let sixteen = embree::Instances::<16>::new(scene.clone(), firsts.clone());
            engines.push(("embree-fast-1".into(), Box::new(one)));
            engines.push(("embree-fast-16".into(), Box::new(sixteen)));
        }
        engines.retain(|(name, _)| wanted(name));
        let truth = truth(&snapshot, firsts, &rays, kind);
        let truth = |_: &str| Truth::without_ties(&truth);
        let (seconds, beside) = (options.seconds, measure::embree);
        let question = kind.question();
        let rows = measure::measure(&mut engines, &rays, question, &truth, seconds, pool, beside);
        let rows: Vec<Row> = rows
            .into_iter()
            .map(|row| Row {
                scene: format!("{name}, {} instances", forest.placed.len()),
                triangles: forest.triangles(),
                kind: kind.name().into(),
                ..row
            })
            .collect();
        report::table(&rows);
    }
    Ok(())
}

/// Returns the true answers for a scene of instances, tracing one ray per call.
fn truth(snapshot: &SceneSnapshot, firsts: &Arc<[u32]>, rays: &[Ray], kind: Kind) -> Vec<Answer> {
    let rays: Vec<_> = rays.iter().map(widened).collect();
    let mut single = InstancesSingle::new(snapshot.clone(), firsts.clone());
    single.load(&rays, kind.question());
    single.trace(0..rays.len());
    single.answers()
}

/// Measures how long a commit takes after all instances have moved, and how much memory instances
/// use.
fn commits(count: usize, api: Option<&Arc<Api>>, threads: usize) -> Result<(), String> {
    let (before, moved) = (resident(), [0, 1].map(|seed| Forest::bunnies(count, seed)));
    let [forest, other] = moved;
    let (forest, other) = (forest?, other?);
    let before = before.max(resident());
    let (mut scene, ids, snapshot) = committed(&forest)?;
    let bytes = resident().saturating_sub(before) as f64 / count as f64;
    drop(snapshot);
    let mut best = [f64::INFINITY; 2];
    for round in 0..6 {
        let to = if round % 2 == 0 { &other } else { &forest };
        let start = Instant::now();
        for (&id, &(_, matrix)) in ids.iter().zip(&to.placed) {
            scene.place(id, matrix).map_err(|e| e.to_string())?;
        }
        let placed = Instant::now();
        let snapshot = scene.commit().map_err(|e| e.to_string())?;
        let times = [placed - start, placed.elapsed()].map(|time| time.as_secs_f64() * 1e3);
        best = [0, 1].map(|i| best[i].min(times[i]));
        drop(snapshot);
    }
    let [place, commit] = best;
    println!("\n{} moved instances, {threads} threads", report::grouped(count));
    println!("  intertri: place {place:.2} ms, commit {commit:.2} ms; about {bytes:.0} bytes each");
    if let Some(api) = api {
        let build = Build {
            robust: false,
            high: false,
            avx2: false,
            threads: threads as u32,
            collect: false,
        };
        let scene = embree::Scene::of_instances(api, &forest.meshes, &forest.placed, build)?;
        let mut best = f64::INFINITY;
        for round in 0..4 {
            let to = if round % 2 == 0 { &other } else { &forest };
            let matrices: Vec<_> = to.placed.iter().map(|&(_, matrix)| matrix).collect();
            let start = Instant::now();
            scene.place(&matrices);
            best = best.min(start.elapsed().as_secs_f64() * 1e3);
        }
        println!("  Embree: place and commit {best:.2} ms");
    }
    Ok(())
}

/// Returns the number of bytes of this process that are resident in memory.
pub fn resident() -> usize {
    let pages = std::fs::read_to_string("/proc/self/statm").unwrap_or_default();
    let pages = pages.split(' ').nth(1).and_then(|pages| pages.parse::<usize>().ok());
    pages.unwrap_or(0) * 4096
}
