//! `intertri trace`: traces a file of rays, so that other programs can use or check the answers.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use clap::Args;
use intertri::fixed::Bits;
use intertri::{RayOf, Threshold, TriangleOf};
use intertri_scene::{Coordinate, Rays, RaysFormat, Rounding};
use intertri_trace::{Bvh, BvhScalar};

use crate::commands::options::{grid_bits, grid_bounds, rays_format, threshold_of};
use crate::engine::batch::{Batch, Question};
use crate::engine::engine64::Engine64;
use crate::engine::engines::Engines;
use crate::engine::fixed::GridReport;
use crate::engine::model::{Model, ModelIn, ModelNotes, ModelOptions};
use crate::engine::name::EngineName;
use crate::engine::ray_engine::RayEngine;
use crate::engine::scalar_name::ScalarName;
use crate::engine::tracer::Tracer;
use crate::engine::triangles::triangles;
use crate::error::{Error, Result, note};
use crate::io::answers::{Format, Query};
use crate::io::numbers;
use crate::io::output::Output;
use crate::io::pipeline;
use crate::io::pipes::widen_pipes;
use crate::io::progress::{Progress, timed};
use crate::io::same_file::refuse_same_file;
use crate::report::print::print;
use crate::report::rounding::Rounded;
use crate::report::trace::{TraceReport, TraceSeconds};

/// The number of batches in the pipeline per thread: while a thread works on one, another is read
/// or written.
const BATCHES: usize = 2;

/// The number of chunks per batch: large enough to make handing over a batch cheap, and small
/// enough to keep all batches in the cache.
const CHUNKS: usize = 4;

/// Trace a file of rays: find the triangle that each ray hits, and where
///
/// RAYS have one of three formats. CSV begins with a header line: ox,oy,oz,t_min,dx,dy,dz,t_max in
/// any order, where t_min (0) and t_max (inf) are optional. Raw has eight little-endian f32 per
/// ray: origin x y z, t_min, dir x y z, t_max. Raw64 is the same in f64. A hit counts if t_min <= t
/// < t_max and t > 0.
///
/// Answers are computed from the numbers in the files; a decimal is read as the nearest f64. Engines
/// other than exact and oracle support only f32; the numbers that they round are counted on
/// standard error and in the report.
///
/// ANSWERS are CSV by default: ray,triangle,t,u,v. Rays and triangles are numbered from 0,
/// triangles in the order of the file and those of a polygon in sequence; u and v are the weights
/// of the second and third corner. Numbers are the shortest decimals that read back to the same
/// bits, in scientific notation below 1e-5 and from 1e16 on. Misses have empty cells. A raw answer
/// is 32 bytes long, little-endian: the triangle as i64 (-1 for a miss), then t, u and v as f64.
#[derive(Args)]
#[expect(clippy::doc_markdown, reason = "the text is printed verbatim as help")]
#[expect(clippy::struct_excessive_bools, reason = "these are command-line flags")]
pub(crate) struct Options {
    /// An OBJ, PLY, STL or glTF file, or a hierarchy saved by build
    model: PathBuf,

    /// The file of rays, or - for standard input
    #[arg(long, value_name = "FILE")]
    rays: PathBuf,

    /// The format of the rays [default: by the extension .csv, .f32 (raw) or .f64 (raw64);
    /// otherwise csv if the file begins with a header line]
    #[arg(long, value_name = "FORMAT", value_parser = rays_format())]
    rays_format: Option<RaysFormat>,

    /// The file for the answers [default: standard output]
    #[arg(short, long, value_name = "FILE")]
    output: Option<PathBuf>,

    /// The format of the answers
    #[arg(long, value_enum, default_value_t = Format::Csv)]
    format: Format,

    /// Short for --format raw
    #[arg(long, conflicts_with = "format")]
    raw: bool,

    /// Only report whether anything is hit: 1 or 0 (CSV ray,hit; raw: one byte per ray)
    #[arg(long, conflicts_with_all = ["all", "crossings"])]
    any: bool,

    /// Report every hit, not only the closest: one line per hit, in order of t, and one line with
    /// empty cells for a miss (raw: 40 bytes per record, with the i64 number of the ray first).
    /// With the exact engine, an edge belongs to each of its triangles
    #[arg(long, conflicts_with = "crossings")]
    all: bool,

    /// Report every crossing, in order of t; each edge belongs to one of its triangles. The format
    /// is that of --all with an additional column, side: 1 if the ray leaves (it runs with the
    /// normal) and -1 if it enters (raw: 48 bytes, with an i64 at the end, which is 0 for a miss).
    /// For a ray from inside a closed mesh, the sides sum to 1. Only for the exact and fixed
    /// engines
    #[arg(long)]
    crossings: bool,

    /// The engine that finds the hits; raster does not trace rays
    #[arg(long, value_enum, default_value_t = EngineName::Exact)]
    engine: EngineName,

    /// The scalar to trace in; f64 works only with the exact and oracle engines [default for these
    /// two: whichever represents all numbers exactly, so the choice affects only the speed; for
    /// other engines: f32]
    #[arg(long, value_enum)]
    scalar: Option<ScalarName>,

    /// The number of bits per coordinate on the grid of the fixed engine, 1 to 20 [default: 20].
    /// The grid depends on the model, but not on the rays
    #[arg(long, value_name = "BITS", value_parser = grid_bits, allow_hyphen_values = true)]
    grid: Option<Bits>,

    /// Extend the grid of the fixed engine to contain this box, given by two opposite corners; rays
    /// must start within the grid
    #[arg(long, value_name = "X,Y,Z,X,Y,Z", value_parser = grid_bounds, allow_hyphen_values = true)]
    grid_bounds: Option<[[f32; 3]; 2]>,

    /// Count rays that start outside the grid of the fixed engine as misses, and report how many
    /// there were
    #[arg(long)]
    skip_outside: bool,

    /// The smallest |normal . direction| that does not count as parallel, and the largest t that
    /// does not count as a hit, for the certified and reference engines [default: 1e-9]
    #[arg(long, value_name = "X", value_parser = numbers::threshold, allow_hyphen_values = true)]
    threshold: Option<Threshold>,

    #[command(flatten)]
    reading: ModelOptions,

    /// Print the report as JSON on standard output
    #[arg(long, requires = "output")]
    json: bool,
}

impl Options {
    fn query(&self) -> Query {
        match self {
            Self { any: true, .. } => Query::Any,
            Self { all: true, .. } => Query::All,
            Self { crossings: true, .. } => Query::Crossings,
            _ => Query::Closest,
        }
    }

    /// Refuses contradictory options.
    fn check(&self) -> Result<()> {
        if self.scalar == Some(ScalarName::F64) {
            Engine64::check(self.engine)?;
        }
        if self.engine == EngineName::Raster {
            return Err(Error::usage(EngineName::ANSWERS_NO_RAYS));
        }
        if self.crossings && !matches!(self.engine, EngineName::Exact | EngineName::Fixed) {
            return Err(Error::usage(format!(
                "--crossings: engine {} may count an edge twice; choose exact or fixed",
                self.engine
            )));
        }
        let given = [
            ("--grid", self.grid.is_some()),
            ("--grid-bounds", self.grid_bounds.is_some()),
            ("--skip-outside", self.skip_outside),
        ];
        match given.into_iter().find(|(_, given)| *given && self.engine != EngineName::Fixed) {
            Some((option, _)) => Err(Error::usage(format!(
                "{option} is only for the fixed engine; add --engine fixed"
            ))),
            None => Ok(()),
        }
    }
}

/// Loads the model and answers the rays.
pub(crate) fn run(options: &Options) -> Result<()> {
    // Refuse bad combinations of options before any work.
    options.check()?;
    let threshold = threshold_of(options.engine, options.threshold)?;
    refuse_same_file(options.output.as_deref(), &[&options.model, &options.rays])?;
    let rays = Rays::open(&options.rays, options.rays_format)?;
    let mut seconds = TraceSeconds::default();
    let model = timed(&mut seconds.load, || {
        let _bar = Progress::new("load", None);
        Model::load(&options.model, options.reading)
    })?;
    refuse_output(options, &model.files)?;
    match scalar(options, &model, &rays) {
        ScalarName::F32 => {
            let scene = in_f32(options, threshold, model, &mut seconds)?;
            answer(options, threshold, &scene, rays, seconds)
        }
        ScalarName::F64 => {
            let scene = in_f64(options, model, &mut seconds)?;
            answer(options, threshold, &scene, rays, seconds)
        }
    }
}

/// Returns the scalar to trace the model and the rays in. By default, this is f32 if the engine
/// supports only f32, or if f32 represents the model and the format of the rays exactly; otherwise
/// it is f64.
///
/// The default depends on the format of the rays, but not on their coordinates, so that no ray
/// affects how another ray is traced. The answers of `exact` are the same in both scalars if f32
/// represents all numbers.
fn scalar(options: &Options, model: &Model, rays: &Rays<'_>) -> ScalarName {
    let single = !options.engine.is_exact() || rays.are_f32() && model.is_f32();
    options.scalar.unwrap_or(if single { ScalarName::F32 } else { ScalarName::F64 })
}

/// An engine for a model, and the details of the model that the report contains.
struct Traced<T> {
    engine: T,
    triangles: usize,
    grid: Option<GridReport>,
    rounding: Rounding,
    notes: ModelNotes,
}

/// Creates any engine for the model in f32.
fn in_f32(
    options: &Options,
    threshold: Option<Threshold>,
    model: Model,
    seconds: &mut TraceSeconds,
) -> Result<Traced<RayEngine>> {
    let (triangles, bvh, rounding, notes) =
        timed(&mut seconds.load, || corners(options, model.in_f32()?))?;
    let room_for = options.grid_bounds.map_or(vec![], Vec::from);
    let mut engines = Engines::new(&triangles, threshold.unwrap_or_default())
        .on_grid(options.grid.unwrap_or(Bits::FINE), room_for)
        .with_bvh(bvh);
    let engine = engines.engine(options.engine).map_err(|error| error.of(&options.model))?;
    seconds.build = engines.seconds;
    Ok(Traced { engine, triangles: triangles.len(), grid: engines.grid(), rounding, notes })
}

/// Creates an exact engine for the model in f64.
fn in_f64(options: &Options, model: Model, seconds: &mut TraceSeconds) -> Result<Traced<Engine64>> {
    let (triangles, bvh, rounding, notes) =
        timed(&mut seconds.load, || corners(options, model.in_f64()?))?;
    let count = triangles.len();
    let engine = timed(&mut seconds.build, || Engine64::new(options.engine, triangles, bvh))
        .map_err(|error| error.of(&options.model))?;
    Ok(Traced { engine, triangles: count, grid: None, rounding, notes })
}

/// The triangles of a model, its saved hierarchy if there is one, its rounding counts, and its
/// notes.
type Corners<S> = (Vec<TriangleOf<S>>, Option<Arc<Bvh<S>>>, Rounding, ModelNotes);

/// Extracts the parts of a model that are traced, and drops its mesh.
fn corners<S: Coordinate + BvhScalar>(options: &Options, model: ModelIn<S>) -> Result<Corners<S>> {
    let triangles = triangles(&model.mesh).map_err(|error| error.of(&options.model))?;
    Ok((triangles, model.bvh, model.rounding, model.notes))
}

/// Refuses to overwrite a file that was read in addition to the model.
fn refuse_output(options: &Options, files: &[PathBuf]) -> Result<()> {
    let files: Vec<&Path> = files.iter().map(PathBuf::as_path).collect();
    refuse_same_file(options.output.as_deref(), &files)
}

/// Answers the rays with an engine, and reports the result.
fn answer<T: Tracer>(
    options: &Options,
    threshold: Option<Threshold>,
    scene: &Traced<T>,
    mut rays: Rays<'_>,
    mut seconds: TraceSeconds,
) -> Result<()> {
    let mut output = Output::open(options.output.as_deref())?;
    let format = if options.raw { Format::Raw } else { options.format };
    let question = Question { engine: &scene.engine, query: options.query(), format };
    let done = answer_all(options, &question, &mut rays, &mut output, &mut seconds)?;
    output.finish()?;
    if done.outside > 0 {
        note(&format!(
            "rays that start outside the grid and therefore hit nothing: {}",
            done.outside
        ));
    }
    let rounded = Rounded { model: scene.rounding, rays: rays.rounding() };
    if options.scalar.is_none() && !rounded.is_nothing() {
        let engine = options.engine;
        note(&format!(
            "engine {engine} supports only f32: {rounded}; if that is intended, add --scalar f32"
        ));
    }

    // A report cannot share standard output with the answers.
    if options.output.is_none() {
        return Ok(());
    }
    let report = TraceReport {
        model: options.model.clone(),
        output: options.output.clone(),
        triangles: scene.triangles,
        notes: scene.notes.clone(),
        engine: options.engine,
        scalar: ScalarName::of::<T::Scalar>(),
        rounded,
        threshold: threshold.map(Threshold::get),
        rays: done.rays,
        hits: done.hits,
        outside: done.outside,
        grid: scene.grid,
        seconds,
    };
    print(&report, options.json)
}

/// The numbers of rays that were answered, that hit something, and that started outside the grid.
#[derive(Default)]
struct Done {
    rays: u64,
    hits: u64,
    outside: u64,
}

/// Reads rays, computes their answers and writes the answers, all at the same time.
fn answer_all<T: Tracer>(
    options: &Options,
    question: &Question<'_, T>,
    rays: &mut Rays<'_>,
    output: &mut Output,
    seconds: &mut TraceSeconds,
) -> Result<Done> {
    // A ray may hit every triangle, so batches are small if the query is for all hits or crossings.
    let many = matches!(question.query, Query::All | Query::Crossings);
    let size = if many { 16 } else { CHUNKS * question.engine.chunk_size() };
    let threads = rayon::current_num_threads();
    let bar = Progress::new("trace", rays.total());
    let (mut read, mut done) = (0, Done::default());
    output.write(question.format.header(question.query))?;
    widen_pipes();
    pipeline::run(
        (0..BATCHES * threads).map(|_| Batch::<T::Scalar>::default()),
        |batch| {
            timed(&mut seconds.read, || rays.read(&mut batch.rays, size))?;
            batch.first = read;
            read += batch.rays.len() as u64;
            Ok(!batch.rays.is_empty())
        },
        |batch| batch.answer(question),
        |batch| {
            if let (Some(&number), false) = (batch.outside.first(), options.skip_outside) {
                let ray = &batch.rays[(number - batch.first) as usize];
                return Err(outside(options, number, ray));
            }
            bar.add(batch.rays.len());
            done.rays += batch.rays.len() as u64;
            done.hits += batch.hits;
            done.outside += batch.outside.len() as u64;
            seconds.trace += batch.seconds;
            timed(&mut seconds.write, || output.write(batch.bytes()))
        },
    )?;
    // The number of threads that worked at the same time cannot exceed the number of batches.
    let threads = threads.min(done.rays.div_ceil(size as u64) as usize).max(1);
    seconds.trace /= threads as f64;
    Ok(done)
}

/// Returns the error for a ray that starts outside the grid.
fn outside<S: Coordinate>(options: &Options, number: u64, ray: &RayOf<S>) -> Error {
    let cause = format!(
        "ray {number} starts at {:?}, outside the grid; extend it with --grid-bounds, or count \
         such rays as misses with --skip-outside",
        ray.origin
    );
    Error::at(options.rays.display(), cause)
}
