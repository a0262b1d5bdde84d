//! `intertri trace`: a file of rays answered, so that other programs can ask and compare.

use std::path::PathBuf;

use clap::Args;
use intertri::fixed::Bits;
use intertri::{Ray, Threshold};
use intertri_scene::{Rays, load};

use crate::answers::{Answers, Format, Question, Verb};
use crate::engine::{self, Engines};
use crate::error::{Error, Result};
use crate::fixed::parse_bits;
use crate::numbers;
use crate::output::Output;
use crate::progress::{Progress, timed};
use crate::report::{self, Trace, TraceSeconds};
use crate::stream::{stream, widen_pipes};

/// Batches that are on their way at once, for each thread: it has one, and while it is at it another is read
/// or written.
const BATCHES: usize = 2;

/// Pieces of a batch: enough that handing it on is nothing beside them, and few enough that all batches stay in
/// the cache.
const PIECES: usize = 4;

/// Rays, and what they are told.
#[derive(Default)]
struct Batch {
    rays: Vec<Ray>,
    /// The number of the first.
    first: u64,
    answers: Answers,
    /// How many hit something.
    hits: u64,
    /// How long it took to find that out.
    seconds: f64,
}

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

    /// Every hit, not only the closest: a line for each, in the order of the triangles, and one with
    /// empty cells for a miss (with --raw, each record follows the i64 number of its ray: 40 bytes)
    #[arg(long)]
    all: bool,

    /// What finds the hits
    #[arg(long, value_enum, default_value_t = engine::Name::Certified)]
    engine: engine::Name,

    /// The bits of a coordinate on the grid of engine fixed, 1 to 20 [default: 20]. The grid holds the
    /// origins of all rays, which are therefore all read first
    #[arg(long, value_name = "BITS", value_parser = parse_bits, allow_hyphen_values = true)]
    grid: Option<Bits>,

    /// The smallest |normal . direction| that is not parallel, and the largest t that is no hit
    #[arg(long, value_name = "X", value_parser = numbers::threshold, default_value = "1e-9", allow_hyphen_values = true)]
    threshold: Threshold,

    /// Print a report for programs, as JSON, on the standard output
    #[arg(long, requires = "output")]
    json: bool,
}

/// Answers.
pub(crate) fn run(options: &Options) -> Result<()> {
    // What can be refused is refused before the work.
    let on_grid = options.engine == engine::Name::Fixed;
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
    let verb = match options {
        Options { any: true, .. } => Verb::Any,
        Options { all: true, .. } => Verb::All,
        _ => Verb::Closest,
    };

    // A grid must hold the origins of all rays, so for that they are read beforehand.
    let (mut early, mut asked) = (vec![], vec![]);
    if on_grid {
        loop {
            timed(&mut seconds.read, || rays.read(&mut asked, 1 << 16))?;
            if asked.is_empty() {
                break;
            }
            early.extend_from_slice(&asked);
        }
    }

    let from = early.iter().map(|ray| ray.origin).collect();
    let mut engines = Engines::new(&triangles, options.threshold)
        .on_grid(options.grid.unwrap_or(Bits::FINE), from);
    let engine = engines.engine(options.engine)?;
    seconds.build = engines.seconds;
    let mut output = Output::open(options.output.as_deref())?;

    // A ray may hit every triangle: of all hits, those of few rays at once.
    let size = if verb == Verb::All { 16 } else { PIECES * engine.piece() };
    let threads = rayon::current_num_threads();
    let bar = Progress::new("trace", rays.total());
    let (mut early, mut read, mut done, mut hits) = (early.chunks(size), 0, 0, 0);
    let format = if options.raw { Format::Raw } else { Format::Csv };
    let question = Question { engine: &engine, verb, format };
    output.write(format.header(verb))?;
    widen_pipes();
    stream(
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
        |Batch { rays, first, answers, hits, seconds }| {
            *seconds = 0.0;
            *hits = timed(seconds, || answers.ask(&question, rays, *first));
        },
        |batch| {
            bar.add(batch.rays.len());
            done += batch.rays.len() as u64;
            hits += batch.hits;
            seconds.trace += batch.seconds;
            timed(&mut seconds.write, || output.write(batch.answers.bytes()))
        },
    )?;
    drop(bar);
    output.finish()?;
    // So many threads were at it at the same time.
    let threads = threads.min(done.div_ceil(size as u64) as usize).max(1);
    seconds.trace /= threads as f64;

    // Where the answers are the standard output, there is no place for a report.
    if options.output.is_none() {
        return Ok(());
    }
    let report = Trace {
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
    report::print(&report, options.json)
}
