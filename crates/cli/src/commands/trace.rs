//! `intertri trace`: a file of rays answered, so that other programs can ask and compare.

use std::path::PathBuf;

use clap::Args;
use intertri::fixed::Bits;
use intertri::{Ray, Threshold};
use intertri_scene::{Rays, load};

use crate::commands::options::grid_bits;
use crate::engine::batch::{Batch, Question};
use crate::engine::engines::Engines;
use crate::engine::name::EngineName;
use crate::error::{Error, Result};
use crate::io::answers::{Format, Query};
use crate::io::numbers;
use crate::io::output::Output;
use crate::io::pipeline;
use crate::io::pipes::widen_pipes;
use crate::io::progress::{Progress, timed};
use crate::report::print::print;
use crate::report::trace::{TraceReport, TraceSeconds};

/// Batches in the pipeline for each thread: while it works on one, another is read or written.
const BATCHES: usize = 2;

/// Chunks of a batch: enough that handing it on costs little beside them, few enough that all batches stay
/// in the cache.
const CHUNKS: usize = 4;

/// Answer a file of rays: what does each hit, and where?
///
/// RAYS are raw, eight little-endian f32 a ray in the order origin x y z, t_min, dir x y z, t_max; or
/// CSV, which begins with a line of names: ox,oy,oz,t_min,dx,dy,dz,t_max in any order, of which t_min
/// (0) and t_max (inf) may be left out. A hit counts where t_min <= t < t_max.
///
/// ANSWERS are CSV: ray,triangle,t,u,v, both numbered from 0, triangles in the order of the file and a
/// polygon as a fan; u and v are the weights of the second and third corner. Numbers are the shortest
/// decimals that read back to the same bits, in scientific notation below 1e-5 and from 1e16 on. A miss
/// has empty cells. With --raw: i64 triangle (-1 for a miss), f64 t, u, v; little-endian, 32 bytes.
#[derive(Args)]
#[expect(clippy::doc_markdown, reason = "it is printed as it stands")]
#[expect(clippy::struct_excessive_bools, reason = "they are the flags of a command line")]
pub(crate) struct Options {
    /// An OBJ, PLY or STL file
    model: PathBuf,

    /// The file of rays, or - for the standard input
    #[arg(long, value_name = "FILE")]
    rays: PathBuf,

    /// Where the answers go [default: the standard output]
    #[arg(short, long, value_name = "FILE")]
    output: Option<PathBuf>,

    /// Write binary records instead of CSV
    #[arg(long)]
    raw: bool,

    /// Only say whether anything is hit: 1 or 0 (CSV ray,hit; one byte a ray with --raw)
    #[arg(long, conflicts_with = "all")]
    any: bool,

    /// Every hit, not only the closest: a line for each, in order of t, and one with
    /// empty cells for a miss (with --raw, each record follows the i64 number of its ray: 40 bytes)
    #[arg(long)]
    all: bool,

    /// What finds the hits
    #[arg(long, value_enum, default_value_t = EngineName::Certified)]
    engine: EngineName,

    /// The bits of a coordinate on the grid of engine fixed, 1 to 20 [default: 20]. The grid holds the
    /// origins of all rays, which are therefore all read first
    #[arg(long, value_name = "BITS", value_parser = grid_bits, allow_hyphen_values = true)]
    grid: Option<Bits>,

    /// The smallest |normal . direction| that is not parallel, and the largest t that is no hit
    #[arg(long, value_name = "X", value_parser = numbers::threshold, default_value = "1e-9", allow_hyphen_values = true)]
    threshold: Threshold,

    /// Print a report for programs, as JSON, on the standard output
    #[arg(long, requires = "output")]
    json: bool,
}

impl Options {
    fn query(&self) -> Query {
        match self {
            Self { any: true, .. } => Query::Any,
            Self { all: true, .. } => Query::All,
            _ => Query::Closest,
        }
    }
}

/// Answers the rays.
pub(crate) fn run(options: &Options) -> Result<()> {
    // What can be refused is refused before the work.
    let on_grid = options.engine == EngineName::Fixed;
    if options.grid.is_some() && !on_grid {
        return Err(Error::new("--grid is for engine fixed; add --engine fixed"));
    }
    let mut rays = Rays::open(&options.rays)?;
    let mut seconds = TraceSeconds::default();
    let mesh = timed(&mut seconds.load, || {
        let _bar = Progress::new("load", None);
        load(&options.model)
    })?;
    let triangles = mesh.to_triangles();

    // A grid must hold the origins of all rays, so for that they are read beforehand.
    let early = if on_grid { read_all(&mut rays, &mut seconds.read)? } else { vec![] };
    let origins = early.iter().map(|ray| ray.origin).collect();
    let mut engines = Engines::new(&triangles, options.threshold)
        .on_grid(options.grid.unwrap_or(Bits::FINE), origins);
    let engine = engines.engine(options.engine)?;
    seconds.build = engines.seconds;

    let mut output = Output::open(options.output.as_deref())?;
    let format = if options.raw { Format::Raw } else { Format::Csv };
    let question = Question { engine: &engine, query: options.query(), format };
    let (done, hits) = answer_all(&question, &early, &mut rays, &mut output, &mut seconds)?;
    output.finish()?;

    // Where the answers are the standard output, there is no place for a report.
    if options.output.is_none() {
        return Ok(());
    }
    let report = TraceReport {
        model: options.model.clone(),
        output: options.output.clone(),
        triangles: triangles.len(),
        engine: options.engine,
        threshold: options.threshold.get(),
        rays: done,
        hits,
        grid: engines.grid(),
        seconds,
    };
    print(&report, options.json)
}

/// All rays of a file at once.
fn read_all(rays: &mut Rays<'_>, seconds: &mut f64) -> Result<Vec<Ray>> {
    let (mut all, mut some) = (vec![], vec![]);
    loop {
        timed(seconds, || rays.read(&mut some, 1 << 16))?;
        if some.is_empty() {
            return Ok(all);
        }
        all.extend_from_slice(&some);
    }
}

/// Reads, answers and writes at the same time: first the rays that were read early, then the rest. Gives
/// the number of rays, and of those that hit something.
fn answer_all(
    question: &Question<'_>,
    early: &[Ray],
    rays: &mut Rays<'_>,
    output: &mut Output,
    seconds: &mut TraceSeconds,
) -> Result<(u64, u64)> {
    // A ray may hit every triangle; so of those that ask for all hits, a batch has few.
    let all = question.query == Query::All;
    let size = if all { 16 } else { CHUNKS * question.engine.chunk_size() };
    let threads = rayon::current_num_threads();
    let bar = Progress::new("trace", rays.total());
    let (mut early, mut read, mut done, mut hits) = (early.chunks(size), 0, 0, 0);
    output.write(question.format.header(question.query))?;
    widen_pipes();
    pipeline::run(
        (0..BATCHES * threads).map(|_| Batch::default()),
        |batch| {
            match early.next() {
                Some(some) => some.clone_into(&mut batch.rays),
                None => timed(&mut seconds.read, || rays.read(&mut batch.rays, size))?,
            }
            batch.first = read;
            read += batch.rays.len() as u64;
            Ok(!batch.rays.is_empty())
        },
        |batch| batch.answer(question),
        |batch| {
            bar.add(batch.rays.len());
            done += batch.rays.len() as u64;
            hits += batch.hits;
            seconds.trace += batch.seconds;
            timed(&mut seconds.write, || output.write(batch.bytes()))
        },
    )?;
    // Threads worked at the same time, as many of them as there were batches.
    let threads = threads.min(done.div_ceil(size as u64) as usize).max(1);
    seconds.trace /= threads as f64;
    Ok((done, hits))
}
