//! `intertri advise`: finds the lowest precision that is enough for a model.

use std::path::PathBuf;
use std::sync::Arc;
use std::time::Instant;

use clap::Args;
use intertri::fixed::{Bits, Grid};
use intertri::{Hit, Ray, Threshold, Triangle};
use intertri_lab::advise::{Arithmetic, PinholeCamera, SampledPixel, needs, scan};
use intertri_scene::{Rounding, Scene};
use intertri_trace::Bvh;

use crate::commands::options::CameraOptions;
use crate::engine::engines::Engines;
use crate::engine::frame::{Frame, Shadows};
use crate::engine::model::{Model, ModelNotes, ModelOptions};
use crate::engine::name::EngineName;
use crate::engine::pixels::primary_rays;
use crate::engine::raster::Raster;
use crate::engine::ray_engine::RayEngine;
use crate::engine::tracer::Tracer;
use crate::engine::triangles::triangles;
use crate::error::{Error, Result};
use crate::io::numbers;
use crate::io::progress::Progress;
use crate::report::advise::{AdviseReport, Choice};
use crate::report::print::print;
use crate::report::rounding::Rounded;

/// The largest number of pixels in the sample.
const SAMPLE: usize = 1 << 16;

/// The number of times that each choice is timed.
const TURNS: usize = 3;

/// The grids to try, given as bits per coordinate.
const GRIDS: std::ops::RangeInclusive<u32> = 8..=20;

/// Find the lowest precision that is enough for a model: the coarsest grid, or exact answers
///
/// Measures the model as seen by the camera, bounds how many pixels each choice can get wrong, and
/// checks these bounds on a sample with exact arithmetic. Recommends the choice with the fewest
/// bits per vertex that stays within the tolerance. A pixel is wrong if it shows a different
/// triangle than it would without any rounding or snapping. Plain f32, which no engine offers, is
/// listed for comparison. Coordinates that are not exact in f32 are rounded first and counted in
/// the report.
#[derive(Args)]
pub(crate) struct Options {
    /// An OBJ, PLY, STL or glTF file, or a hierarchy saved by build [default: the built-in scene]
    model: Option<PathBuf>,

    /// The number of pixels that may be wrong, or a share such as 0.1%
    #[arg(long, value_name = "PIXELS", value_parser = tolerance, default_value = "0", allow_hyphen_values = true)]
    tolerance: Tolerance,

    /// The width and height in pixels
    #[arg(long, value_name = "WxH", default_value = "1024x768", value_parser = numbers::size)]
    size: (u32, u32),

    #[command(flatten)]
    reading: ModelOptions,

    /// Print the report as JSON
    #[arg(long)]
    json: bool,

    #[command(flatten)]
    camera: CameraOptions,
}

/// The number of pixels that may be wrong.
#[derive(Clone, Copy)]
enum Tolerance {
    Pixels(u64),
    /// A fraction of all pixels.
    Share(f64),
}

impl Tolerance {
    /// Returns the number of wrong pixels to tolerate among `total`.
    fn of(self, total: usize) -> u64 {
        match self {
            Self::Pixels(pixels) => pixels,
            Self::Share(share) => (share * total as f64) as u64,
        }
    }
}

fn tolerance(text: &str) -> std::result::Result<Tolerance, String> {
    let what = || "give a number of pixels, or a share such as 0.1%".to_owned();
    match text.strip_suffix('%') {
        None => text.parse().map(Tolerance::Pixels).map_err(|_| what()),
        Some(share) => match share.parse::<f64>() {
            Ok(share) if (0.0..=100.0).contains(&share) => Ok(Tolerance::Share(share / 100.0)),
            _ => Err(what()),
        },
    }
}

/// Predicts the effect of each choice, tries all choices on a sample, and recommends one.
pub(crate) fn run(options: &Options) -> Result<()> {
    let start = Instant::now();
    let (width, height) = options.size;
    let (scene, bvh, rounding, notes) = load(options)?;
    let triangles = triangles(&scene.mesh)?;

    // A threshold of 0 hides no triangle.
    let zero = Threshold::new(0.0).unwrap_or_default();
    let raster = Raster::new(&scene, &triangles, options.size, zero);
    let mut engines = Engines::new(&triangles, zero).with_bvh(bvh);
    let frame = Frame::draw(&scene, &raster, &mut engines, EngineName::Certified, Shadows::None)?;
    let pixel = |x, y| scene.camera.ray(x, y, width, height);
    let camera = PinholeCamera {
        eye: scene.camera.eye(),
        axes: scene.camera.axes(),
        half_height: scene.camera.half_height(),
        size: options.size,
        ray: &pixel,
    };
    let needs = needs(&triangles, &camera, &frame.hits, Threshold::DEFAULT.get());
    let threshold = Threshold::new(needs.threshold).unwrap_or(zero);

    // Bound the worst case of each choice.
    let candidates = candidates(&triangles, camera.eye, threshold);
    let arithmetics: Vec<Arithmetic> = candidates.iter().filter_map(|c| c.arithmetic).collect();
    let every = frame.hits.len().div_ceil(SAMPLE);
    let bar = Progress::new("predict", Some(u64::from(height)));
    let found = scan(&triangles, &camera, &frame.hits, &arithmetics, every, &|rows| bar.add(rows));
    drop(bar);

    // Try each choice on the sample.
    let bar = Progress::new("sample", Some(candidates.len() as u64));
    let rays: Vec<Ray> = found.sample.iter().map(|e| pixel(e.pixel.0, e.pixel.1)).collect();
    let tolerance = options.tolerance.of(frame.hits.len());
    let (triangles, sample, eye) = (&triangles[..], &found.sample[..], camera.eye);
    let primary = &primary_rays(&scene.camera, options.size)?[..];
    let mut trials = Trials { triangles, threshold, eye, engines, primary, rays: &rays, sample };
    let mut choices = vec![];
    let bound = |k: usize| (found.shift[k], found.doubtful[k], found.doubtful_in_sample[k]);
    let mut bounds = (0..arithmetics.len()).map(bound);
    for candidate in candidates {
        let (wrong, speed) = trials.run(&candidate)?;
        let (pixels, wrong_at_most, wrong_in_sample_at_most) =
            candidate.arithmetic.and_then(|_| bounds.next()).unwrap_or_default();
        choices.push(Choice {
            name: candidate.name,
            bits_a_vertex: candidate.bits,
            pixels,
            wrong_at_most,
            wrong_in_sample_at_most,
            wrong_in_sample: wrong as u64,
            speed,
            enough: wrong_at_most <= tolerance,
        });
        bar.add(1);
    }
    drop(bar);

    let take = choices.iter().find(|choice| choice.enough && choice.speed.is_some());
    let report = AdviseReport {
        model: options.model.clone(),
        notes,
        rounded: Rounded::of_model(rounding),
        size: [width, height],
        tolerance,
        sample: rays.len(),
        rays: primary.len(),
        take: take.map(|choice| choice.name.clone()),
        threshold: threshold.get(),
        needs,
        choices,
        seconds: start.elapsed().as_secs_f64(),
    };
    print(&report, options.json)?;
    refuse_nothing(&report)
}

/// Loads the model or the built-in scene. Also returns the saved hierarchy, if any, and what was
/// rounded or changed while reading.
fn load(options: &Options) -> Result<(Scene, Option<Arc<Bvh>>, Rounding, ModelNotes)> {
    let (width, height) = options.size;
    let load = |path| Model::load(path, options.reading)?.in_f32();
    let model = options.model.as_deref().map(load).transpose()?;
    let (bvh, rounding, notes) = model
        .as_ref()
        .map(|model| (model.bvh.clone(), model.rounding, model.notes.clone()))
        .unwrap_or_default();
    let mesh = model.map(|model| model.mesh);
    let scene = options.camera.scene(mesh, f64::from(width) / f64::from(height))?;
    Ok((scene, bvh, rounding, notes))
}

/// Returns an error if no choice guarantees the tolerance.
fn refuse_nothing(report: &AdviseReport) -> Result<()> {
    if report.take.is_some() {
        return Ok(());
    }
    let tolerance = report.tolerance;
    Err(Error::new(format!(
        "no choice guarantees at most {tolerance} wrong pixels; allow more with --tolerance"
    )))
}

/// A choice to evaluate.
struct Candidate {
    name: String,
    /// The total number of bits of a vertex's three coordinates.
    bits: u32,
    /// The arithmetic, or `None` for exact arithmetic, which moves no point and decides every case.
    arithmetic: Option<Arithmetic>,
    /// The engine and its grid, or `None` if no engine offers this choice.
    engine: Option<(EngineName, Bits)>,
}

/// Returns all choices, in ascending order of bits per vertex.
fn candidates(triangles: &[Triangle], eye: [f32; 3], threshold: Threshold) -> Vec<Candidate> {
    let mut candidates = vec![];
    for b in GRIDS {
        let points = triangles.iter().flat_map(|t| t.0).chain([eye]);
        // A model with non-finite corners fits no grid.
        let grid = Bits::of_grid(b).and_then(|bits| Grid::around(points, bits));
        let Ok(grid) = grid else { continue };
        let q = grid.bits().q();
        candidates.push(Candidate {
            name: format!("fixed --grid {b}"),
            bits: 3 * (b + 1),
            arithmetic: Some(Arithmetic::Grid { step: grid.step(), q }),
            engine: Some((EngineName::Fixed, grid.bits())),
        });
    }
    let floating = |name: &str, arithmetic, engine: Option<EngineName>| Candidate {
        name: name.to_owned(),
        bits: 96,
        arithmetic,
        engine: engine.map(|name| (name, Bits::FINE)),
    };
    let double = Some(Arithmetic::Double { threshold: threshold.get() });
    candidates.push(floating("exact", None, Some(EngineName::Exact)));
    candidates.push(floating("certified", double, Some(EngineName::Certified)));
    candidates.push(floating("plain f32", Some(Arithmetic::Single), None));
    candidates
}

/// Everything that is needed to try candidates on the sample.
struct Trials<'a> {
    triangles: &'a [Triangle],
    threshold: Threshold,
    eye: [f32; 3],
    /// The engines, which share the hierarchy over the triangles.
    engines: Engines<'a>,
    /// All camera rays of the image, in the order in which `bench` traces them.
    primary: &'a [Ray],
    /// The rays of the sample.
    rays: &'a [Ray],
    /// The exact answer for each ray of the sample.
    sample: &'a [SampledPixel],
}

impl Trials<'_> {
    /// Returns the number of wrong answers and, if an engine offers the choice, its speed in
    /// millions of rays per second.
    fn run(&mut self, candidate: &Candidate) -> Result<(usize, Option<f64>)> {
        let Some((name, bits)) = candidate.engine else {
            let wrong = |e: &&SampledPixel| !e.allows(e.single);
            return Ok((self.sample.iter().filter(wrong).count(), None));
        };
        let engine = self.engine(name, bits)?;
        let wrong = wrong_answers(&engine, self.rays, self.sample);
        Ok((wrong, Some(speed(&engine, self.primary))))
    }

    /// Creates an engine. Engines that do not snap the triangles share one hierarchy.
    fn engine(&mut self, name: EngineName, bits: Bits) -> Result<RayEngine> {
        if name != EngineName::Fixed {
            return self.engines.engine(name);
        }
        let engines = Engines::new(self.triangles, self.threshold);
        engines.on_grid(bits, vec![self.eye]).engine(name)
    }
}

/// Counts the wrong answers of an engine.
fn wrong_answers(engine: &RayEngine, rays: &[Ray], sample: &[SampledPixel]) -> usize {
    let mut hits = vec![Hit::MISS; rays.len()];
    engine.closest(rays, &mut hits);
    let right =
        |exact: &SampledPixel, hit: &Hit| exact.allows(hit.is_hit().then_some(hit.triangle));
    sample.iter().zip(&hits).filter(|&(exact, hit)| !right(exact, hit)).count()
}

/// Measures an engine's speed in millions of rays per second, as the median of a few turns.
fn speed(engine: &RayEngine, rays: &[Ray]) -> f64 {
    let mut hits = vec![Hit::MISS; rays.len()];
    // The first turn is only a warm-up.
    engine.closest(rays, &mut hits);
    let mut seconds = [0.0; TURNS];
    for seconds in &mut seconds {
        let start = Instant::now();
        engine.closest(rays, &mut hits);
        *seconds = start.elapsed().as_secs_f64();
    }
    seconds.sort_by(f64::total_cmp);
    rays.len() as f64 / seconds[TURNS / 2].max(1e-9) * 1e-6
}
