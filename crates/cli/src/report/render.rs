//! The report of `render` and its `--check`.

use std::fmt;
use std::path::PathBuf;

use intertri_lab::tables::grouped;
use serde::Serialize;

use crate::engine::fixed::GridReport;
use crate::engine::frame::Shadows;
use crate::engine::model::ModelNotes;
use crate::engine::name::EngineName;
use crate::engine::scalar_name::ScalarName;
use crate::report::check::{Count, Difference};
use crate::report::phrases::{model, rate, write_grid};
use crate::report::rounding::Rounded;

/// The report of `render`.
#[derive(Serialize)]
pub(crate) struct RenderReport {
    /// The path to the model; null for the built-in scene.
    pub(crate) model: Option<PathBuf>,
    pub(crate) output: PathBuf,
    pub(crate) triangles: u64,
    /// The number of instances and of their meshes; null if the model was traced as a single mesh.
    pub(crate) instances: Option<InstanceCounts>,
    /// Everything in the model that was omitted, repaired or guessed.
    pub(crate) notes: ModelNotes,
    pub(crate) size: [u32; 2],
    pub(crate) engine: EngineName,
    /// The scalar that the model was traced in.
    pub(crate) scalar: ScalarName,
    pub(crate) rounded: Rounded,
    pub(crate) shadows: Shadows,
    /// The threshold; null if the engine has none.
    pub(crate) threshold: Option<f64>,
    /// The up direction.
    pub(crate) up: [f32; 3],
    /// Whether the user set the up direction.
    #[serde(skip)]
    pub(crate) up_given: bool,
    /// The number of pixels. Each has a camera ray, unless the z-buffer drew the image.
    pub(crate) rays: u64,
    /// The number of pixels that show a triangle.
    pub(crate) hits: u64,
    /// The number of pixels in shadow.
    pub(crate) dark: u64,
    pub(crate) shadow_rays: u64,
    /// The number of ray/triangle tests. Plain loops and `fixed` do not count tests.
    pub(crate) tests: u64,
    /// The number of tests that f32 lanes left to f64 or to exact arithmetic.
    pub(crate) undecided: u64,
    /// The grid, if one of the two engines is `fixed`.
    pub(crate) grid: Option<GridReport>,
    pub(crate) seconds: RenderSeconds,
    pub(crate) check: Option<CheckReport>,
}

/// The number of instances, and of the meshes that they share.
#[derive(Clone, Copy, Serialize)]
pub(crate) struct InstanceCounts {
    pub(crate) instances: usize,
    pub(crate) meshes: usize,
    /// The number of triangles in the meshes, counting each mesh once.
    pub(crate) mesh_triangles: u64,
}

/// The time of each step, in seconds.
#[derive(Default, Serialize)]
pub(crate) struct RenderSeconds {
    pub(crate) load: f64,
    pub(crate) build: f64,
    /// Tracing camera rays, or drawing the z-buffer.
    pub(crate) trace: f64,
    /// Tracing shadow rays, or counting shadow volumes.
    pub(crate) shadow: f64,
    pub(crate) shade: f64,
    pub(crate) write: f64,
    /// Drawing with the engine of `--check`, and comparing the images.
    pub(crate) check: f64,
    /// The whole run, up to the report.
    pub(crate) total: f64,
}

/// The result of `--check`.
#[derive(Serialize)]
pub(crate) struct CheckReport {
    pub(crate) engine: EngineName,
    pub(crate) shadows: Shadows,
    /// The number of pixels that differ in any compared value.
    pub(crate) differing_pixels: usize,
    /// How many of these pixels are excused.
    pub(crate) excused_pixels: usize,
    pub(crate) differing_hits: usize,
    pub(crate) excused_hits: usize,
    pub(crate) differing_shadows: usize,
    pub(crate) excused_shadows: usize,
    /// The largest distance between two hits on the same triangle, along a pixel's ray and in scene
    /// units.
    pub(crate) largest_distance: f64,
    /// The image of the differences.
    pub(crate) picture: PathBuf,
    /// The time that the second engine took, in seconds, excluding builds.
    pub(crate) seconds: f64,
}

impl CheckReport {
    pub(crate) fn new(
        engine: EngineName,
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

impl fmt::Display for RenderReport {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let [width, height] = self.size;
        writeln!(f, "{}: {width}x{height} pixels", self.output.display())?;
        let model = model(self.model.as_deref());
        writeln!(f, "{:>12} triangles of {model}", grouped(self.triangles))?;
        if let Some(InstanceCounts { instances, meshes, mesh_triangles }) = self.instances {
            let [instances, meshes] = [instances, meshes].map(|count| grouped(count as u64));
            let triangles = grouped(mesh_triangles);
            writeln!(
                f,
                "{instances:>12} instances (unique meshes: {meshes}, unique triangles: {triangles})"
            )?;
        }
        if self.model.is_some() && !self.up_given {
            let up = self.up.map(|x| x.to_string()).join(",");
            writeln!(f, "{up:>12} is up; for a model whose z is up, add --up 0,0,1")?;
        }
        self.rounded.write_line(f)?;
        self.write_rays(f)?;
        write_grid(f, self.grid)?;
        self.seconds.fmt(f)?;
        if let Some(check) = &self.check {
            check.fmt(f)?;
        }
        Ok(())
    }
}

impl RenderReport {
    /// Writes the lines about the rays and their tests.
    fn write_rays(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let what = if self.engine == EngineName::Raster { "pixels" } else { "rays" };
        let speed = rate(self.rays, self.seconds.trace);
        let scalar = self.scalar.mention();
        writeln!(f, "{:>12} {what}, {speed}, engine {}{scalar}", grouped(self.rays), self.engine)?;
        if self.shadow_rays > 0 {
            let speed = rate(self.shadow_rays, self.seconds.shadow);
            writeln!(f, "{:>12} shadow rays, {speed}", grouped(self.shadow_rays))?;
        }
        if self.tests > 0 {
            let share = self.undecided as f64 / self.tests as f64 * 100.0;
            let how = match self.engine {
                EngineName::Certified => "in f64",
                _ => "exactly",
            };
            writeln!(f, "{:>12} tests, {share:.4} % settled {how}", grouped(self.tests))?;
        }
        Ok(())
    }
}

impl fmt::Display for RenderSeconds {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { load, build, trace, shadow, shade, write, check, total } = self;
        let steps = [
            ("load", load),
            ("build", build),
            ("trace", trace),
            ("shadows", shadow),
            ("shade", shade),
            ("write", write),
            ("check", check),
        ];
        write!(f, "     seconds: ")?;
        for (step, seconds) in steps.iter().filter(|(_, seconds)| **seconds > 0.0) {
            write!(f, "{step} {seconds:.3}, ")?;
        }
        write!(f, "in all {total:.3}")
    }
}

/// Writes additional lines, each preceded by a newline.
impl fmt::Display for CheckReport {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (pixels, seconds) = (grouped(self.differing_pixels as u64), self.seconds);
        let engine = self.engine;
        write!(f, "\n{pixels:>12} pixels differ from engine {engine} ({seconds:.3} seconds)")?;
        if self.differing_pixels > 0 {
            write!(f, "\n{:>12} of them are excused", grouped(self.excused_pixels as u64))?;
        }
        if self.largest_distance > 0.0 {
            let far = self.largest_distance;
            write!(f, "\n{far:>12.1e} largest distance between the two hits of a triangle")?;
        }
        Ok(())
    }
}
