//! Counts leaks: rays from inside a closed mesh, aimed at its vertices and edges, that hit nothing.
//!
//! A ray from inside a closed mesh always hits it, regardless of how its direction was rounded, so
//! every miss is an error of the tracer.

mod aim;
mod grid;
mod inside;

use std::path::PathBuf;
use std::sync::Arc;

use clap::Args;
use intertri_raster::Adjacency;
use intertri_scene::Scene;
use intertri_trace::Bvh;
use serde::Serialize;

use self::aim::{Aim, Target};
use crate::embree::Api;
use crate::engine::Question;
use crate::{engines, report, scenes};

#[derive(Args)]
pub struct Options {
    /// Meshes to test, named like the scenes of the `rays` command. By default, all closed
    /// generated meshes and all shared models. Open meshes are skipped.
    #[arg(long, value_delimiter = ',')]
    scene: Vec<String>,
    /// Number of rays per mesh and target.
    #[arg(long, default_value_t = 1_000_000, value_parser = clap::value_parser!(u32).range(1..))]
    rays: u32,
    /// Engines to test; see the `rays` command. `fixed-aimed` traces rays aimed exactly on the grid
    /// of `fixed`.
    #[arg(
        long,
        value_delimiter = ',',
        default_value = "certified,certified-single,exact,exact-single,fixed,fixed-aimed,embree-fast-1,embree-fast-16,\
                         embree-robust-1,embree-robust-16,obvhs,parry,bvh"
    )]
    engine: Vec<String>,
    /// Number of threads; 0 uses all.
    #[arg(long, default_value_t = 0)]
    threads: usize,
    /// File to write the figures to as JSON.
    #[arg(long)]
    json: Option<PathBuf>,
    /// Path to Embree's shared library; see the `rays` command.
    #[arg(long, env = "EMBREE")]
    embree: Option<PathBuf>,
}

/// An engine's leaks for one mesh and target.
#[derive(Clone, Debug, Serialize)]
pub struct Row {
    pub mesh: String,
    pub triangles: usize,
    pub target: &'static str,
    pub engine: String,
    pub rays: usize,
    /// The number of rays whose direction is the exact difference between target and origin.
    pub exact: usize,
    pub leaks: usize,
}

/// Measures all meshes, prints a table per target, and writes the figures to the JSON file, if any.
pub fn run(options: &Options) -> Result<(), String> {
    let api = crate::embree(options.embree.clone());
    let pool = crate::pool(options.threads)?;
    let version = api.as_ref().map_or_else(|| "no Embree".into(), |api| api.version());
    println!("{}; {version}", report::cpu());
    let mut names = options.scene.clone();
    if names.is_empty() {
        names.extend(scenes::CLOSED.map(str::to_owned));
        names.extend(scenes::models()?);
    }
    let mut rows = Vec::new();
    for name in &names {
        let scene = scenes::scene(name)?;
        rows.extend(pool.install(|| leaks(name, &scene, options, api.as_ref()))?);
    }
    for target in [Target::Vertices, Target::Edges] {
        let rows: Vec<&Row> = rows.iter().filter(|row| row.target == target.name()).collect();
        report::leaks(&rows);
    }
    match &options.json {
        Some(path) => {
            let text = serde_json::to_string_pretty(&rows).map_err(|e| e.to_string())?;
            crate::write(path, text.as_bytes())
        }
        None => Ok(()),
    }
}

/// Returns the rows for a mesh, or none if the mesh is open.
fn leaks(
    name: &str,
    scene: &Scene,
    options: &Options,
    api: Option<&Arc<Api>>,
) -> Result<Vec<Row>, String> {
    let triangles = scene.mesh.to_triangles();
    let adjacency = Adjacency::new(&triangles);
    let mesh = scenes::short(name);
    if let Some(why) = open(&adjacency) {
        println!("{mesh}: skipped, {why}");
        return Ok(vec![]);
    }
    let rays = options.rays as usize;
    let inside = inside::points(&triangles, rays)?;
    let bvh = Arc::new(Bvh::new(&triangles).map_err(|e| e.to_string())?);
    let mut engines = engines::engines(&options.engine, scene, &triangles, &bvh, api);
    let question = Question { any: false, coherent: false };
    let mut rows = Vec::new();
    for target in [Target::Vertices, Target::Edges] {
        let aims = aim::aims(target, &adjacency, &inside, rays);
        let exact = aims.iter().filter(|aim| aim.is_exact()).count();
        let mut add = |engine: &str, leaks| {
            let (mesh, engine) = (mesh.clone(), engine.to_owned());
            let triangles = triangles.len();
            rows.push(Row { mesh, triangles, target: target.name(), engine, rays, exact, leaks });
        };
        let toward: Vec<_> = aims.iter().map(Aim::ray).collect();
        for (engine, tracer) in &mut engines {
            tracer.load(&toward, question);
            tracer.trace(0..rays);
            add(engine, tracer.answers().iter().filter(|answer| !answer.is_hit()).count());
        }
        if engines::wanted(grid::NAME, &options.engine) {
            add(grid::NAME, grid::leaks(&triangles, &aims)?);
        }
    }
    println!(
        "{mesh}: {} triangles, {} origins",
        report::grouped(triangles.len()),
        report::grouped(inside.len()),
    );
    Ok(rows)
}

/// Returns the reason why a mesh is open, or `None` if it is closed. In a closed mesh, each edge
/// belongs to an even number of triangles. Winding does not matter, because all tracers are
/// two-sided.
fn open(adjacency: &Adjacency) -> Option<String> {
    let odd = adjacency.edges().filter(|edge| edge.sides.len() % 2 == 1).count();
    match (adjacency.edges().count(), odd) {
        (0, _) => Some("no triangle".into()),
        (_, 0) => None,
        (edges, odd) => Some(format!("{odd} of {edges} edges are open")),
    }
}
