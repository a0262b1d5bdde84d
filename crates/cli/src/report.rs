//! What was done, for people and for programs.

use std::fmt;
use std::io::{self, Write};
use std::path::PathBuf;

use intertri_lab::tables::grouped;
use serde::Serialize;

use crate::check::{Count, Difference};
use crate::engine;
use crate::error::{Error, Result};
use crate::fixed;
use crate::render::Shadows;

/// Prints a report on the standard output: a few lines, or JSON and nothing else.
pub(crate) fn print(report: &(impl Serialize + fmt::Display), json: bool) -> Result<()> {
    let text = if json {
        serde_json::to_string_pretty(report).map_err(|error| Error::at("report", error))?
    } else {
        report.to_string()
    };
    writeln!(io::stdout(), "{text}")
        .map_err(|cause| Error::at("standard output", format!("cannot write the report: {cause}")))
}

/// What `render` did.
#[derive(Serialize)]
pub(crate) struct Render {
    /// Null for the built-in scene.
    pub(crate) model: Option<PathBuf>,
    pub(crate) output: PathBuf,
    pub(crate) triangles: usize,
    pub(crate) size: [u32; 2],
    pub(crate) engine: engine::Name,
    pub(crate) shadows: Shadows,
    pub(crate) threshold: f64,
    /// Pixels, each with a ray of the camera unless the z-buffer drew them, and how many of them show
    /// something, and how many of these are in shadow.
    pub(crate) rays: u64,
    pub(crate) hits: u64,
    pub(crate) dark: u64,
    pub(crate) shadow_rays: u64,
    /// Ray/triangle tests of all rays, and how many were replayed in f64; the reference and
    /// `fixed` count none.
    pub(crate) tests: u64,
    pub(crate) undecided: u64,
    /// The grid of engine `fixed`, if one of the two is that.
    pub(crate) grid: Option<fixed::Report>,
    pub(crate) seconds: Seconds,
    pub(crate) check: Option<Check>,
}

/// How long each step took.
#[derive(Default, Serialize)]
pub(crate) struct Seconds {
    pub(crate) load: f64,
    pub(crate) build: f64,
    /// The rays of the camera, or the z-buffer.
    pub(crate) trace: f64,
    /// The shadow rays, or the volumes.
    pub(crate) shadow: f64,
    pub(crate) shade: f64,
    pub(crate) write: f64,
}

/// What `--check` found.
#[derive(Serialize)]
pub(crate) struct Check {
    pub(crate) engine: engine::Name,
    pub(crate) shadows: Shadows,
    /// Pixels that differ at all, in triangle or t, and in shadow; and how many of them may.
    pub(crate) differing_pixels: usize,
    pub(crate) excused_pixels: usize,
    pub(crate) differing_hits: usize,
    pub(crate) excused_hits: usize,
    pub(crate) differing_shadows: usize,
    pub(crate) excused_shadows: usize,
    /// How far apart along a pixel's ray the two hits of one triangle are at most, in units of the
    /// scene.
    pub(crate) largest_distance: f64,
    /// Where they are.
    pub(crate) picture: PathBuf,
    /// For all that the second engine did, but building.
    pub(crate) seconds: f64,
}

impl Check {
    pub(crate) fn new(
        engine: engine::Name,
        shadows: Shadows,
        differs: &Difference,
        largest_distance: f64,
        picture: PathBuf,
        seconds: f64,
    ) -> Self {
        let pixels = differs.count();
        let [hits, dark] =
            [&differs.hits, &differs.shadows].map(|all| Count::of(all.iter().copied()));
        Self {
            engine,
            shadows,
            differing_pixels: pixels.differ,
            excused_pixels: pixels.excused,
            differing_hits: hits.differ,
            excused_hits: hits.excused,
            differing_shadows: dark.differ,
            excused_shadows: dark.excused,
            largest_distance,
            picture,
            seconds,
        }
    }
}

impl fmt::Display for Render {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let [width, height] = self.size;
        writeln!(f, "{}: {width}x{height} pixels", self.output.display())?;
        let model = match &self.model {
            Some(path) => path.display().to_string(),
            None => "the built-in scene".to_owned(),
        };
        writeln!(f, "{:>12} triangles of {model}", grouped(self.triangles as u64))?;

        let engine = format!("{:?}", self.engine).to_lowercase();
        let rate = speed(self.rays, self.seconds.trace);
        let what = if self.engine == engine::Name::Raster { "pixels" } else { "rays" };
        writeln!(f, "{:>12} {what}, {rate}, engine {engine}", grouped(self.rays))?;
        if self.shadow_rays > 0 {
            let rate = speed(self.shadow_rays, self.seconds.shadow);
            writeln!(f, "{:>12} shadow rays, {rate}", grouped(self.shadow_rays))?;
        }
        if self.tests > 0 {
            let share = self.undecided as f64 / self.tests as f64 * 100.0;
            writeln!(f, "{:>12} tests, {share:.4} % replayed in f64", grouped(self.tests))?;
        }

        write_grid(f, self.grid)?;
        let Seconds { load, build, trace, shadow, shade, write } = self.seconds;
        let steps = [
            ("load", load),
            ("build", build),
            ("trace", trace),
            ("shadows", shadow),
            ("shade", shade),
            ("write", write),
        ];
        let steps = steps.map(|(step, seconds)| format!("{step} {seconds:.3}"));
        write!(f, "     seconds: {}", steps.join(", "))?;

        if let Some(check) = &self.check {
            let engine = format!("{:?}", check.engine).to_lowercase();
            let (pixels, seconds) = (grouped(check.differing_pixels as u64), check.seconds);
            write!(f, "\n{pixels:>12} pixels differ from engine {engine} ({seconds:.3} seconds)")?;
            if check.differing_pixels > 0 {
                write!(f, "\n{:>12} of them may", grouped(check.excused_pixels as u64))?;
            }
            if check.largest_distance > 0.0 {
                let far = check.largest_distance;
                write!(f, "\n{far:>12.1e} between the two hits of a triangle, at most")?;
            }
        }
        Ok(())
    }
}

/// What `trace` did.
#[derive(Serialize)]
pub(crate) struct Trace {
    pub(crate) model: PathBuf,
    /// Null for the standard output.
    pub(crate) output: Option<PathBuf>,
    pub(crate) triangles: usize,
    pub(crate) engine: engine::Name,
    pub(crate) threshold: f64,
    pub(crate) rays: u64,
    /// Rays that hit something.
    pub(crate) hits: u64,
    /// The grid of engine `fixed`.
    pub(crate) grid: Option<fixed::Report>,
    pub(crate) seconds: TraceSeconds,
}

/// How long each step took; of `trace`, how long a thread was at it. The last three go on at the same time.
#[derive(Default, Serialize)]
pub(crate) struct TraceSeconds {
    pub(crate) load: f64,
    pub(crate) build: f64,
    pub(crate) read: f64,
    pub(crate) trace: f64,
    pub(crate) write: f64,
}

impl fmt::Display for Trace {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (rays, hits) = (grouped(self.rays), grouped(self.hits));
        let triangles = grouped(self.triangles as u64);
        writeln!(f, "{triangles:>12} triangles of {}", self.model.display())?;
        let engine = format!("{:?}", self.engine).to_lowercase();
        let rate = speed(self.rays, self.seconds.trace);
        writeln!(f, "{rays:>12} rays, {rate}, engine {engine}")?;
        writeln!(f, "{hits:>12} of them hit something")?;
        write_grid(f, self.grid)?;
        let TraceSeconds { load, build, read, trace, write } = self.seconds;
        write!(
            f,
            "     seconds: load {load:.3}, build {build:.3}, read {read:.3}, trace {trace:.3}, \
             write {write:.3}"
        )
    }
}

/// A line about a grid, if there is one.
fn write_grid(f: &mut fmt::Formatter<'_>, grid: Option<fixed::Report>) -> fmt::Result {
    let Some(fixed::Report { bits, direction_bits, step, moved, strays }) = grid else {
        return Ok(());
    };
    writeln!(
        f,
        "{bits:>12} bits of grid and {direction_bits} of direction: a step is {step:.1e}, points moved by up to \
         {moved:.1e}, rays stray by less than {strays:.1e}"
    )
}

/// So many rays in so much time.
fn speed(rays: u64, seconds: f64) -> String {
    if seconds > 0.0 {
        format!("{:.2} million a second", rays as f64 / seconds * 1e-6)
    } else {
        "no time taken".to_owned()
    }
}
