//! `intertri advise`: model no more than a scene needs.

use std::fmt;
use std::path::PathBuf;
use std::time::Instant;

use clap::Args;
use intertri::fixed::{Bits, Grid};
use intertri::{Certified, Double, Hit, Ray, Threshold, Triangle};
use intertri_lab::advise::{Arithmetic, Exact, Needs, View, needs, scan};
use intertri_scene::load;
use serde::Serialize;

use crate::camera;
use crate::engine::{Engine, Engines, Name};
use crate::error::{Error, Result};
use crate::frame::Frame;
use crate::numbers;
use crate::progress::Progress;
use crate::raster::Raster;
use crate::render::Shadows;
use crate::report;

/// Pixels of the sample, at most.
const SAMPLE: usize = 1 << 16;

/// The grids that are tried, by the bits of a coordinate.
const GRIDS: std::ops::RangeInclusive<u32> = 8..=20;

/// Say what a model needs: the coarsest grid, or else f64 answers
///
/// Measures the model as the camera sees it, bounds how many pixels each choice can get wrong, checks
/// that on a sample against exact arithmetic, and names the choice that takes the fewest bits a vertex
/// of those that meet the tolerance. A pixel is wrong if it shows another triangle than it would
/// without any rounding or snapping. Plain f32, which no engine offers, is told for comparison.
#[derive(Args)]
pub(crate) struct Options {
    /// An OBJ, PLY or STL file [default: the built-in scene]
    model: Option<PathBuf>,

    /// How many pixels may be wrong: a number, or a share such as 0.1%
    #[arg(long, value_name = "PIXELS", value_parser = tolerance, default_value = "0", allow_hyphen_values = true)]
    tolerance: Tolerance,

    /// Pixels in a row, and rows
    #[arg(long, value_name = "WxH", default_value = "1024x768", value_parser = numbers::size)]
    size: (u32, u32),

    /// Print a report for programs, as JSON
    #[arg(long)]
    json: bool,

    #[command(flatten)]
    camera: camera::Options,
}

/// How many pixels may be wrong.
#[derive(Clone, Copy)]
enum Tolerance {
    Pixels(u64),
    /// Of all pixels.
    Share(f64),
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

/// What can be chosen, and what it would do.
#[derive(Clone, Serialize)]
struct Choice {
    name: String,
    /// Of the three coordinates of a vertex.
    bits_a_vertex: u32,
    /// How far what is seen moves at most, in pixels.
    pixels: f64,
    /// How many pixels of the frame can be wrong at most.
    wrong_at_most: u64,
    /// The same of the sample, and how many of it are.
    wrong_in_sample_at_most: u64,
    wrong_in_sample: u64,
    /// Millions of rays a second, of the sample, here and now; null for what no engine does.
    speed: Option<f64>,
    enough: bool,
}

#[derive(Serialize)]
struct Report {
    model: Option<PathBuf>,
    size: [u32; 2],
    /// Pixels that may be wrong.
    tolerance: u64,
    needs: Needs,
    /// Rays of the sample.
    sample: usize,
    choices: Vec<Choice>,
    /// The name of the one to take, if one meets the tolerance.
    take: Option<String>,
    /// The `Threshold` to take.
    threshold: f64,
    seconds: f64,
}

/// What is asked, by name.
struct Candidate {
    name: String,
    bits: u32,
    arithmetic: Arithmetic,
    engine: Option<(Name, Bits)>,
}

/// Advises.
pub(crate) fn run(options: &Options) -> Result<()> {
    let start = Instant::now();
    let (width, height) = options.size;
    let model = options.model.as_deref().map(load).transpose()?;
    let scene = options.camera.scene(model, f64::from(width) / f64::from(height))?;
    let triangles = scene.mesh.to_triangles();

    // What is seen, whatever the threshold.
    let zero = Threshold::new(0.0).unwrap_or_default();
    let raster = Raster::new(&scene, &triangles, options.size, zero);
    let mut engines = Engines::new(&triangles, zero);
    let frame = Frame::draw(&scene, &raster, &mut engines, Name::Certified, Shadows::None)?;
    let pixel = |x, y| scene.camera.ray(x, y, width, height);
    let view = View {
        eye: scene.camera.eye(),
        axes: scene.camera.axes(),
        half_height: scene.camera.half_height(),
        size: options.size,
        ray: &pixel,
    };
    let needs = needs(&triangles, &view, &frame.hits, Threshold::DEFAULT.get());
    let threshold = Threshold::new(needs.threshold).unwrap_or(zero);

    // What each choice can do.
    let candidates = candidates(&triangles, view.eye, threshold);
    let arithmetics: Vec<Arithmetic> = candidates.iter().map(|c| c.arithmetic).collect();
    let every = frame.hits.len().div_ceil(SAMPLE);
    let bar = Progress::new("predict", Some(u64::from(height)));
    let found = scan(&triangles, &view, &frame.hits, &arithmetics, every, &|rows| bar.add(rows));
    drop(bar);

    // What it does.
    let bar = Progress::new("sample", Some(candidates.len() as u64));
    let rays: Vec<Ray> = found.sample.iter().map(|e| pixel(e.pixel.0, e.pixel.1)).collect();
    let tolerance = match options.tolerance {
        Tolerance::Pixels(pixels) => pixels,
        Tolerance::Share(share) => (share * frame.hits.len() as f64) as u64,
    };
    let mut choices = vec![];
    for (k, candidate) in candidates.into_iter().enumerate() {
        let (wrong, speed) = match candidate.engine {
            None => {
                let wrong = |e: &&Exact| !e.allows(e.single.map(u64::from));
                (found.sample.iter().filter(wrong).count(), None)
            }
            Some((name, bits)) => {
                // One hierarchy is enough for those that have the triangles as they are.
                let engine = match engines.engine(Name::Certified)? {
                    Engine::Certified(bvh, _) if name == Name::Certified => {
                        Engine::Certified(bvh, Certified::new(threshold))
                    }
                    Engine::Certified(bvh, _) if name == Name::Double => {
                        Engine::Double(bvh, Double::new(threshold))
                    }
                    _ => {
                        let engines = Engines::new(&triangles, threshold);
                        engines.on_grid(bits, vec![view.eye]).engine(name)?
                    }
                };
                let (wrong, speed) = ask(&engine, &rays, &found.sample);
                (wrong, Some(speed))
            }
        };
        choices.push(Choice {
            name: candidate.name,
            bits_a_vertex: candidate.bits,
            pixels: found.shift[k],
            wrong_at_most: found.doubtful[k],
            wrong_in_sample_at_most: found.doubtful_in_sample[k],
            wrong_in_sample: wrong as u64,
            speed,
            enough: found.doubtful[k] <= tolerance,
        });
        bar.add(1);
    }
    drop(bar);

    let take = choices.iter().find(|choice| choice.enough && choice.speed.is_some());
    let report = Report {
        model: options.model.clone(),
        size: [width, height],
        tolerance,
        sample: rays.len(),
        take: take.map(|choice| choice.name.clone()),
        threshold: threshold.get(),
        needs,
        choices,
        seconds: start.elapsed().as_secs_f64(),
    };
    report::print(&report, options.json)?;
    match &report.take {
        Some(_) => Ok(()),
        None => Err(Error::new(format!(
            "no choice is sure to keep within {tolerance} wrong pixels; allow more by --tolerance"
        ))),
    }
}

/// All choices, the cheapest first.
fn candidates(triangles: &[Triangle], eye: [f32; 3], threshold: Threshold) -> Vec<Candidate> {
    let mut candidates = vec![];
    for b in GRIDS {
        let points = triangles.iter().flat_map(|t| t.0).chain([eye]);
        // A model with corners that are not finite is on no grid.
        let grid = Bits::of_grid(b).and_then(|bits| Grid::around(points, bits));
        let Ok(grid) = grid else { continue };
        let q = grid.bits().q();
        candidates.push(Candidate {
            name: format!("fixed --grid {b}"),
            bits: 3 * (b + 1),
            arithmetic: Arithmetic::Grid { step: grid.step(), q },
            engine: Some((Name::Fixed, grid.bits())),
        });
    }
    let floating = |name: &str, arithmetic, engine: Option<Name>| Candidate {
        name: name.to_owned(),
        bits: 96,
        arithmetic,
        engine: engine.map(|name| (name, Bits::FINE)),
    };
    let double = Arithmetic::Double { threshold: threshold.get() };
    candidates.push(floating("certified", double, Some(Name::Certified)));
    candidates.push(floating("double", double, Some(Name::Double)));
    candidates.push(floating("plain f32", Arithmetic::Single, None));
    candidates
}

/// How many answers of an engine are wrong, and how many millions it gives in a second.
fn ask(engine: &Engine, rays: &[Ray], sample: &[Exact]) -> (usize, f64) {
    let mut hits = vec![Hit::MISS; rays.len()];
    // The first time warms the caches up.
    engine.closest(rays, &mut hits);
    let start = Instant::now();
    engine.closest(rays, &mut hits);
    let seconds = start.elapsed().as_secs_f64();
    let right = |(exact, hit): (&Exact, &Hit)| exact.allows(hit.is_hit().then_some(hit.triangle));
    let wrong = sample.iter().zip(&hits).filter(|&(exact, hit)| !right((exact, hit))).count();
    (wrong, rays.len() as f64 / seconds.max(1e-9) * 1e-6)
}

impl fmt::Display for Report {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { needs, size: [width, height], .. } = self;
        let model = match &self.model {
            Some(path) => path.display().to_string(),
            None => "the built-in scene".to_owned(),
        };
        writeln!(f, "{model}, {width}x{height} pixels")?;
        let lines = [
            ("triangles", format!("{}, {} without area", needs.triangles, needs.degenerate)),
            ("extent", format!("{:.2e}, farthest coordinate {:.2e}", needs.extent, needs.offset)),
            (
                "smallest",
                format!(
                    "edge {:.1e}, altitude {:.1e}",
                    needs.shortest_edge, needs.smallest_altitude
                ),
            ),
            (
                "seen",
                format!(
                    "from {:.2e} to {:.2e} away, in {} pixels; a pixel is {:.1e} wide there",
                    needs.nearest, needs.farthest, needs.hits, needs.pixel
                ),
            ),
            ("grazing", format!("{:.2} % of these, under six degrees", needs.grazing * 100.0)),
        ];
        for (what, text) in lines {
            writeln!(f, "{what:>10}  {text}")?;
        }

        let sample = format!("of {} asked", self.sample);
        writeln!(
            f,
            "\n{:16} {:>8} {:>9} {:>21} {:>27} {:>8}",
            "", "bits a", "moves by", "wrong pixels", sample, "million"
        )?;
        writeln!(
            f,
            "{:16} {:>8} {:>9} {:>21} {:>13} {:>13} {:>8}",
            "", "vertex", "pixels", "at most", "at most", "were wrong", "rays/s"
        )?;
        for choice in &self.choices {
            let speed = choice.speed.map_or(String::new(), |speed| format!("{speed:.1}"));
            let mark = if Some(&choice.name) == self.take.as_ref() { "  <" } else { "" };
            writeln!(
                f,
                "{:16} {:>8} {:>9.1e} {:>21} {:>13} {:>13} {:>8}{mark}",
                choice.name,
                choice.bits_a_vertex,
                choice.pixels,
                choice.wrong_at_most,
                choice.wrong_in_sample_at_most,
                choice.wrong_in_sample,
                speed
            )?;
        }

        let tolerance = match self.tolerance {
            0 => "no pixel may be wrong".to_owned(),
            pixels => format!("{pixels} pixels may be wrong"),
        };
        match &self.take {
            Some(name) => writeln!(
                f,
                "\ntake {name}: {tolerance}, and nothing with fewer bits is sure to keep to that"
            )?,
            None => writeln!(f, "\n{tolerance}: nothing is sure to keep to that")?,
        }
        let default = Threshold::DEFAULT.get();
        write!(
            f,
            "threshold {:e}: no hit has |normal . direction| below {:.1e} or t below {:.1e}",
            self.threshold, needs.smallest_slope, needs.smallest_t
        )?;
        if needs.lost > 0 {
            write!(f, "; the default, {default:e}, would lose {} of them", needs.lost)?;
        }
        Ok(())
    }
}
