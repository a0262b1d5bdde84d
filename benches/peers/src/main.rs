//! Traces the same rays with intertri and other tracers, alternating in one process.

mod builds;
mod bvh;
#[cfg(feature = "chart")]
mod chart;
mod cliffs;
mod clock;
mod distances;
mod doubles;
mod embree;
mod engine;
mod engines;
mod fixed;
mod flush_to_zero;
#[cfg(feature = "chart")]
mod fronts;
mod in_f64;
mod instances;
mod leaks;
mod lists;
mod measure;
mod moves;
mod obvhs;
mod ours;
mod parry;
mod programs;
mod rays;
mod reference;
mod report;
mod scenes;
mod solids;
#[cfg(feature = "chart")]
mod stability;
#[cfg(feature = "tinybvh")]
mod tinybvh;
mod truth;
mod utm;

use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::sync::Arc;

use clap::{Args, Parser, Subcommand};
use intertri::simd::Level;
use intertri::{Mode, Ray};
use intertri_trace::Bvh;
use rayon::ThreadPool;

use crate::clock::Clock;
use crate::embree::Api;
use crate::engine::{Answer, Engine, Question};
use crate::measure::Row;
use crate::ours::Single;
use crate::rays::{Kind, Order};
use crate::truth::Truth;

/// Rays through intertri and its peers: million rays a second, and wrong answers.
#[derive(Parser)]
struct Cli {
    #[command(subcommand)]
    command: Command,
}

#[derive(Subcommand)]
enum Command {
    /// Measure rays.
    Rays(Options),
    /// Measure how long the hierarchies take to build.
    Builds(BuildOptions),
    /// Count rays from inside closed meshes, aimed at vertices and edges, that hit nothing.
    Leaks(leaks::Options),
    /// Measure every hit of each ray.
    Lists(lists::Options),
    /// Compare scenes in f64 with the same in f32, and with other tracers in f64.
    F64(in_f64::Options),
    /// Measure scenes a kilometre across at the coordinates of a map, in f64.
    Utm(utm::Options),
    /// Measure scenes of instances beside the same flattened, and beside Embree's instances.
    Instances(instances::Options),
    #[cfg(feature = "chart")]
    /// Draw what `rays --json` wrote: NAME.svg and NAME.png.
    Chart(ChartOptions),
    /// Measure signed distances of a million points.
    Distances(distances::Options),
    /// Measure saving, loading and refitting.
    Moves(moves::Options),
    /// Measure how many times longer the same rays take in hostile scenes.
    Cliffs(cliffs::Options),
    /// List the engines and the scenes.
    List,
}

#[derive(Args)]
struct Options {
    /// Scenes: names of the list, sphere-N with N triangles, `growth` for spheres of 10^2 to 10^7, or
    /// paths of models.
    #[arg(long, value_delimiter = ',', default_value = "bunny,kitchen,sphere")]
    scene: Vec<String>,
    /// Kinds of rays.
    #[arg(long, value_delimiter = ',', default_value = "primary,shadow,light,diffuse")]
    kind: Vec<Kind>,
    /// Engines, or the beginning of their names up to a dash; all by default.
    #[arg(long, value_delimiter = ',')]
    engine: Vec<String>,
    /// Threads; 0 for all.
    #[arg(long, default_value_t = 1)]
    threads: usize,
    /// Seconds for each engine, scene and kind.
    #[arg(long, default_value_t = 1.0)]
    seconds: f64,
    /// Pixels along a side of the picture, a power of two.
    #[arg(long, default_value_t = 1024)]
    size: u32,
    /// The order of the pixels.
    #[arg(long, value_enum, default_value_t = Order::Tiles)]
    order: Order,
    /// Rays to compare with the plain loop of the f64 reference; by default fewer on large scenes, where that
    /// is slow.
    #[arg(long)]
    reference: Option<usize>,
    /// A quick run: by default certified and Embree's fast and robust calls, 0.3 seconds, no reference.
    #[arg(long)]
    quick: bool,
    /// Where to write the figures as JSON, for the chart among others.
    #[arg(long)]
    json: Option<PathBuf>,
    /// Embree's shared library, version 3 or 4, if it is not installed.
    #[arg(long, env = "EMBREE")]
    embree: Option<PathBuf>,
}

#[derive(Args)]
struct BuildOptions {
    /// Scenes, as for `rays`.
    #[arg(long, value_delimiter = ',', default_value = "bunny,kitchen,sphere")]
    scene: Vec<String>,
    /// Threads; 0 for all.
    #[arg(long, default_value_t = 1)]
    threads: usize,
    /// Embree's shared library, as for `rays`.
    #[arg(long, env = "EMBREE")]
    embree: Option<PathBuf>,
}

#[cfg(feature = "chart")]
#[derive(Args)]
struct ChartOptions {
    /// The files that `rays --json` wrote.
    files: Vec<PathBuf>,
    /// Speed against triangles instead of bars.
    #[arg(long)]
    growth: bool,
    /// Speed and wrong answers, all scenes together, instead of bars; also printed as a table.
    #[arg(long, conflicts_with_all = ["growth", "stability"])]
    fronts: bool,
    /// What `cliffs --json` wrote: time against what makes a scene hostile; also printed as a table.
    #[arg(long, conflicts_with = "growth")]
    stability: bool,
    /// The name of the pictures, without extension.
    #[arg(short, long)]
    output: PathBuf,
}

fn main() -> ExitCode {
    let done = match Cli::parse().command {
        Command::Rays(options) => rays_of_all(options),
        Command::Builds(options) => builds_of_all(&options),
        Command::Leaks(options) => leaks::run(&options),
        Command::Lists(options) => lists::run(&options),
        Command::F64(options) => in_f64::run(&options),
        Command::Utm(options) => utm::run(&options),
        Command::Instances(options) => instances::run(&options),
        #[cfg(feature = "chart")]
        Command::Chart(options) => chart_of_all(&options),
        Command::Distances(options) => distances::run(&options),
        Command::Moves(options) => moves::run(&options),
        Command::Cliffs(options) => cliffs::run(&options),
        Command::List => {
            report::list();
            Ok(())
        }
    };
    match done {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("{error}");
            ExitCode::FAILURE
        }
    }
}

fn rays_of_all(mut options: Options) -> Result<(), String> {
    if !options.size.is_power_of_two() || options.size > 1 << 14 {
        return Err("--size: a power of two, at most 16384".into());
    }
    if options.quick {
        options.seconds = options.seconds.min(0.3);
        options.reference = options.reference.or(Some(0));
        if options.engine.is_empty() {
            options.engine =
                ["certified", "embree-fast", "embree-robust"].map(str::to_owned).into();
        }
    }
    let api = embree(options.embree.clone());
    let pool = pool(options.threads)?;
    let fastest = pool.install(Clock::fastest);
    report::header(fastest, pool.current_num_threads(), options.size);

    let growth = scenes::GROWTH.map(|n| format!("sphere-{n}"));
    let names = options.scene.iter().flat_map(|name| match name.as_str() {
        "growth" => growth.to_vec(),
        name => vec![name.to_owned()],
    });
    let mut rows = Vec::new();
    for name in names {
        let scene = scenes::scene(&name)?;
        let triangles = scene.mesh.to_triangles();
        let bvh = Arc::new(Bvh::new(&triangles).map_err(|e| e.to_string())?);
        let mut engines = engines::engines(&options.engine, &scene, &triangles, &bvh, api.as_ref());
        if engines.is_empty() {
            return Err("no such engine; `list` names them".into());
        }
        for &kind in &options.kind {
            let rays = rays::rays(kind, &scene, &bvh, options.size, options.order);
            if rays.is_empty() {
                continue;
            }
            let mut question = kind.question();
            question.coherent &= options.order != Order::Shuffled;
            let [truth, exact] =
                [Mode::certified(), Mode::exact()].map(|mode| truth(&bvh, &rays, question, mode));
            let few = 2_000_000_000 / triangles.len();
            let some = options.reference.unwrap_or(20_000.min(few));
            let (held, wrong) = reference::differences(&scene.mesh, &rays, question, &truth, some);

            let seconds = options.seconds;
            // `certified` promises the document's answers, all other modes those of geometry.
            let truth = |name: &str| {
                let answers = if name.starts_with("certified") { &truth } else { &exact };
                Truth::new(name, answers, &triangles, &rays)
            };
            let beside = measure::embree;
            let measured =
                measure::measure(&mut engines, &rays, question, &truth, seconds, &pool, beside);
            let measured: Vec<Row> = measured
                .into_iter()
                .map(|row| Row {
                    threads: pool.current_num_threads(),
                    reference: held,
                    reference_wrong: wrong,
                    ..row.of(&name, triangles.len(), kind.name(), options.order)
                })
                .collect();
            report::table(&measured);
            rows.extend(measured);
        }
    }
    options.json.as_ref().map_or(Ok(()), |path| write_rows(path, &rows))
}

fn builds_of_all(options: &BuildOptions) -> Result<(), String> {
    let (api, pool) = (embree(options.embree.clone()), pool(options.threads)?);
    for name in &options.scene {
        let scene = scenes::scene(name)?;
        let triangles = scene.mesh.to_triangles();
        let times = builds::builds(&scene.mesh, &triangles, api.as_ref(), &pool);
        report::builds(name, triangles.len(), pool.current_num_threads(), &times);
    }
    Ok(())
}

#[cfg(feature = "chart")]
fn chart_of_all(options: &ChartOptions) -> Result<(), String> {
    let mut rows: Vec<Row> = Vec::new();
    for path in &options.files {
        let text = std::fs::read(path).map_err(|e| format!("{}: {e}", path.display()))?;
        let more: Vec<Row> =
            serde_json::from_slice(&text).map_err(|e| format!("{}: {e}", path.display()))?;
        rows.extend(more);
    }
    let first = rows.first().ok_or("no figures in the files")?;
    let s = if first.threads == 1 { "" } else { "s" };
    let lines = match () {
        () if options.growth => "",
        () if options.fronts => {
            "; numbers: times as fast as Embree's fast mode (grey line), and wrong answers"
        }
        () if options.stability => {
            "; × the last time over the first; filled: a wrong answer was seen, hollow: none"
        }
        () => "; the line in a bar: eight of ten repeats",
    };
    let caption = format!(
        "{}, {}, {} thread{s}; each engine at its fastest call{lines}",
        intertri_lab::machine::date(),
        report::cpu(),
        first.threads,
    );
    let svg = match () {
        () if options.growth => chart::growth(&rows, &caption),
        () if options.fronts => {
            print!("{}", fronts::table(&rows));
            fronts::chart(&rows, &caption)
        }
        () if options.stability => {
            print!("{}", stability::table(&rows));
            stability::chart(&rows, &caption)
        }
        () => chart::bars(&rows, &caption),
    };
    write(&options.output.with_extension("svg"), svg.to_string().as_bytes())?;
    write(&options.output.with_extension("png"), &intertri_lab::draw::png(&svg)?)
}

fn embree(path: Option<PathBuf>) -> Option<Arc<Api>> {
    let api = Api::open(path);
    api.inspect_err(|e| eprintln!("without Embree: {e}; --embree PATH names its library")).ok()
}

fn pool(threads: usize) -> Result<ThreadPool, String> {
    rayon::ThreadPoolBuilder::new().num_threads(threads).build().map_err(|e| e.to_string())
}

/// Writes the figures of a run as JSON, for the charts.
fn write_rows(path: &Path, rows: &[Row]) -> Result<(), String> {
    let text = serde_json::to_string_pretty(rows).map_err(|e| e.to_string())?;
    write(path, text.as_bytes())
}

fn write(path: &Path, bytes: &[u8]) -> Result<(), String> {
    std::fs::write(path, bytes).map_err(|e| format!("{}: {e}", path.display()))
}

/// The answers of a mode at the portable level, one ray per call: this runs no code for bundles or streams.
fn truth(bvh: &Arc<Bvh>, rays: &[Ray], question: Question, mode: Mode) -> Vec<Answer> {
    let mut single = Single::new(bvh.clone(), mode.at(Level::PORTABLE));
    single.load(rays, question);
    single.trace(0..rays.len());
    single.answers()
}
