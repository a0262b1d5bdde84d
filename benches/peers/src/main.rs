//! Traces the same rays with intertri and with other ray tracers, which take turns in one process.

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

/// Trace the same rays with intertri and other tracers, and compare speed and wrong answers
#[derive(Parser)]
struct Cli {
    #[command(subcommand)]
    command: Command,
}

#[derive(Subcommand)]
enum Command {
    /// Measure how fast rays are traced, and count wrong answers.
    Rays(Options),
    /// Measure how long it takes to build the hierarchies.
    Builds(BuildOptions),
    /// Count leaks: rays from inside closed meshes, aimed at vertices and edges, that hit nothing.
    Leaks(leaks::Options),
    /// Measure queries for every hit of each ray.
    Lists(lists::Options),
    /// Compare scenes in f64 with the same scenes in f32, and with other f64 tracers.
    F64(in_f64::Options),
    /// Measure scenes a kilometre across at map coordinates, in f64.
    Utm(utm::Options),
    /// Compare scenes of instances with the same scenes flattened, and with Embree's instances.
    Instances(instances::Options),
    #[cfg(feature = "chart")]
    /// Draw the figures of `rays --json` or `cliffs --json` as NAME.svg and NAME.png.
    Chart(ChartOptions),
    /// Measure signed distances of a million points.
    Distances(distances::Options),
    /// Measure saving, loading and refitting.
    Moves(moves::Options),
    /// Measure how much longer the same rays take in hostile scenes.
    Cliffs(cliffs::Options),
    /// List the engines and the scenes.
    List,
}

#[derive(Args)]
struct Options {
    /// Scenes to trace: names from `list`, sphere-N with N triangles, `growth` for spheres of 10^2
    /// to 10^7 triangles, or paths to models.
    #[arg(long, value_delimiter = ',', default_value = "bunny,kitchen,sphere")]
    scene: Vec<String>,
    /// Kinds of rays to trace.
    #[arg(long, value_delimiter = ',', default_value = "primary,shadow,light,diffuse")]
    kind: Vec<Kind>,
    /// Engines to measure: names, or prefixes of names that end before a dash; all by default.
    #[arg(long, value_delimiter = ',')]
    engine: Vec<String>,
    /// Number of threads; 0 uses all.
    #[arg(long, default_value_t = 1)]
    threads: usize,
    /// Seconds per engine, scene and kind of ray.
    #[arg(long, default_value_t = 1.0)]
    seconds: f64,
    /// Width and height of the image in pixels; a power of two.
    #[arg(long, default_value_t = 1024)]
    size: u32,
    /// Order of the pixels.
    #[arg(long, value_enum, default_value_t = Order::Tiles)]
    order: Order,
    /// Number of rays to compare with a plain loop over the f64 reference. By default, fewer rays
    /// are compared in large scenes, for which the loop is slow.
    #[arg(long)]
    reference: Option<usize>,
    /// Finish quickly: unless set otherwise, measure only `certified` and Embree's fast and robust
    /// calls, for at most 0.3 seconds, and skip the reference.
    #[arg(long)]
    quick: bool,
    /// File to write the figures to as JSON, for example for `chart`.
    #[arg(long)]
    json: Option<PathBuf>,
    /// Path to the shared library of Embree 3 or 4; needed only if Embree is not installed.
    #[arg(long, env = "EMBREE")]
    embree: Option<PathBuf>,
}

#[derive(Args)]
struct BuildOptions {
    /// Scenes to build; see the `rays` command.
    #[arg(long, value_delimiter = ',', default_value = "bunny,kitchen,sphere")]
    scene: Vec<String>,
    /// Number of threads; 0 uses all.
    #[arg(long, default_value_t = 1)]
    threads: usize,
    /// Path to Embree's shared library; see the `rays` command.
    #[arg(long, env = "EMBREE")]
    embree: Option<PathBuf>,
    /// Run only this builder, and print its milliseconds and bytes.
    #[arg(long, hide = true)]
    only: Option<String>,
}

#[cfg(feature = "chart")]
#[derive(Args)]
struct ChartOptions {
    /// Files written by `rays --json` or `cliffs --json`.
    files: Vec<PathBuf>,
    /// Draw speed against the number of triangles, instead of bars.
    #[arg(long)]
    growth: bool,
    /// Draw speed and wrong answers over all scenes, instead of bars; also print them as a table.
    #[arg(long, conflicts_with_all = ["growth", "stability"])]
    fronts: bool,
    /// Draw time against how hostile a scene is, from files written by `cliffs --json`; also print
    /// a table.
    #[arg(long, conflicts_with = "growth")]
    stability: bool,
    /// Path to write the images to, without an extension.
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
        return Err("--size must be a power of two, at most 16384".into());
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
            return Err("no such engine; `list` shows the names".into());
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
            // `certified` promises the answers of document A. All other engines are compared with
            // the geometrically true answers.
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
    if let (Some(builder), [name]) = (&options.only, &options.scene[..]) {
        let (api, pool) = (embree(options.embree.clone()), pool(options.threads)?);
        let mesh = scenes::scene(name)?.mesh;
        let triangles = mesh.to_triangles();
        if let Some(built) = builds::measure(builder, &mesh, &triangles, api.as_ref(), &pool) {
            println!("{} {}", built.milliseconds, built.bytes);
        }
        return Ok(());
    }
    let mut args = vec!["--threads".into(), options.threads.to_string()];
    if let Some(path) = &options.embree {
        args.extend(["--embree".into(), path.display().to_string()]);
    }
    for name in &options.scene {
        report::builds(name, scenes::scene(name)?.mesh.triangles.len(), options.threads);
        for builder in builds::BUILDERS {
            if let Some(built) = builds::in_own_process(builder, name, &args) {
                report::build(builder, &built);
            }
        }
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
    let first = rows.first().ok_or("the files contain no figures")?;
    let s = if first.threads == 1 { "" } else { "s" };
    let lines = match () {
        () if options.growth => "",
        () if options.fronts => {
            "; numbers: speed relative to Embree's fast mode (grey line), and wrong answers"
        }
        () if options.stability => {
            "; ×: ratio of the last time to the first; filled: wrong answers, hollow: none"
        }
        () => "; the line in a bar covers eight of ten repeats",
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
    api.inspect_err(|e| eprintln!("skipping Embree: {e}; pass its library as --embree PATH")).ok()
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

/// Returns the answers of a mode at the portable level, tracing one ray per call. These calls run
/// none of the code for bundles or streams.
fn truth(bvh: &Arc<Bvh>, rays: &[Ray], question: Question, mode: Mode) -> Vec<Answer> {
    let mut single = Single::new(bvh.clone(), mode.at(Level::PORTABLE));
    single.load(rays, question);
    single.trace(0..rays.len());
    single.answers()
}
