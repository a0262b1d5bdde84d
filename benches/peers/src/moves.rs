//! Measures saving, loading and refitting hierarchies, and compares the times with builds and with
//! Embree's refit.

use std::io::Write;
use std::path::PathBuf;
use std::time::Instant;

use intertri::TriangleOf;
use intertri_scene::Mesh;
use intertri_trace::{Bvh, BvhScalar};
use rayon::ThreadPool;

use crate::embree::{Api, Build, Scene};

#[derive(clap::Args)]
pub struct Options {
    /// Scenes to measure; see the `rays` command.
    #[arg(long, value_delimiter = ',', default_value = "bunny,kitchen,sphere")]
    scene: Vec<String>,
    /// Number of threads; 0 uses all.
    #[arg(long, default_value_t = 1)]
    threads: usize,
    /// Path to Embree's shared library; see the `rays` command.
    #[arg(long, env = "EMBREE")]
    embree: Option<PathBuf>,
}

pub fn run(options: &Options) -> Result<(), String> {
    let (api, pool) = (crate::embree(options.embree.clone()), crate::pool(options.threads)?);
    for name in &options.scene {
        let mesh = crate::scenes::scene(name)?.mesh;
        let triangles = mesh.to_triangles();
        let threads = pool.current_num_threads();
        println!("{name}: {} triangles, {threads} threads, milliseconds", triangles.len());
        let build = pool.install(|| ours(&triangles, twisted))?;
        println!("  in f64");
        let in_f64: Vec<_> = triangles.iter().map(|t| TriangleOf(t.0.map(widened))).collect();
        pool.install(|| ours(&in_f64, |p, by| widened(twisted(p.map(|x| x as f32), by))))?;
        if let Some(api) = &api {
            theirs(api, &mesh, &pool, build)?;
        }
    }
    Ok(())
}

/// Returns the time of the fastest of twenty runs, in milliseconds.
fn fastest<R>(mut work: impl FnMut() -> R) -> f64 {
    let mut once = || {
        let start = Instant::now();
        let _kept = work();
        start.elapsed().as_secs_f64() * 1e3
    };
    (0..20).map(|_| once()).fold(f64::INFINITY, f64::min)
}

/// Moves a point slightly, by a twist about the y axis.
fn twisted(p: [f32; 3], by: f32) -> [f32; 3] {
    let (s, c) = (by * p[1]).sin_cos();
    [p[0] * c - p[2] * s, p[1], p[0] * s + p[2] * c]
}

fn widened(p: [f32; 3]) -> [f64; 3] {
    p.map(f64::from)
}

fn ours<S: BvhScalar>(
    triangles: &[TriangleOf<S>],
    twisted: impl Fn([S; 3], f32) -> [S; 3],
) -> Result<f64, String> {
    let error = |e: &dyn std::fmt::Display| e.to_string();
    let mut bvh = Bvh::<S>::new(triangles).map_err(|e| error(&e))?;
    let build = fastest(|| Bvh::<S>::new(triangles));
    println!("  build             {build:9.2}");
    let tell = |what: &str, time: f64| {
        println!("  {what:17} {time:9.2}   {:5.1} times as fast as building", build / time);
    };

    let moved: Vec<TriangleOf<S>> =
        triangles.iter().map(|t| TriangleOf(t.0.map(|p| twisted(p, 0.3)))).collect();
    let time = fastest(|| bvh.refit(&moved));
    tell("refit", time);
    let refit = bvh.refit(&moved).map_err(|e| error(&e))?;
    println!("  cost after a twist by 0.3: {:.3} times the cost before", refit.ratio());

    let bytes = bvh.to_bytes();
    tell("to bytes", fastest(|| bvh.to_bytes()));
    tell("from bytes", fastest(|| Bvh::<S>::from_bytes(&bytes)));
    let path = std::env::temp_dir().join(format!("intertri-moves-{}", std::process::id()));
    std::fs::File::create(&path)
        .and_then(|mut file| file.write_all(&bytes))
        .map_err(|e| error(&e))?;
    tell("load from a file", fastest(|| Bvh::<S>::load(&path)));
    std::fs::remove_file(&path).map_err(|e| error(&e))?;
    println!("  {:.1} bytes per triangle", bytes.len() as f64 / triangles.len() as f64);
    Ok(build)
}

fn theirs(
    api: &std::sync::Arc<Api>,
    mesh: &Mesh,
    pool: &ThreadPool,
    build: f64,
) -> Result<(), String> {
    let threads = pool.current_num_threads() as u32;
    let build_as = Build { robust: false, high: false, avx2: false, threads, collect: false };
    let scene = Scene::new(api, mesh, build_as)?;
    let scene = scene.for_refits();
    scene.commit();
    let mut turn = 0.3;
    let time = fastest(|| {
        turn = -turn;
        let moved: Vec<[f32; 3]> = mesh.positions.iter().map(|&p| twisted(p, turn)).collect();
        let start = Instant::now();
        scene.refit(&moved);
        start.elapsed()
    });
    let copies = fastest(|| mesh.positions.iter().map(|&p| twisted(p, turn)).collect::<Vec<_>>());
    println!(
        "  Embree's refit    {:9.2}   {:5.1} times intertri's build",
        time - copies,
        build / (time - copies)
    );
    Ok(())
}
