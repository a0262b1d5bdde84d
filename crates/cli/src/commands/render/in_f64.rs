//! `intertri render` in f64, with the exact engines, for coordinates that need more precision than
//! f32 offers.

use std::sync::Arc;
use std::time::Instant;

use intertri_scene::{Scene, shade};
use intertri_trace::Bvh;

use super::cover::cover;
use super::options::Options;
use super::outcome::{refuse_differences, report};
use crate::engine::engine64::Engine64;
use crate::engine::frame::{Frame, Shadows};
use crate::engine::model::{Model, ModelNotes};
use crate::engine::name::EngineName;
use crate::engine::triangles::triangles;
use crate::error::{Error, Result};
use crate::io::progress::{Progress, timed};
use crate::report::check::Difference;
use crate::report::print::print;
use crate::report::render::{CheckReport, RenderSeconds};
use crate::report::rounding::Rounded;

/// Draws the image, and checks it if `--check` is set. If the model is already loaded, `loaded`
/// contains it, and `load` is the time that loading took, in seconds.
pub(super) fn run(
    options: &Options,
    (loaded, load): (Option<Model>, f64),
    start: Instant,
) -> Result<()> {
    check(options)?;
    let (size, mut seconds) = (options.size, RenderSeconds { load, ..RenderSeconds::default() });
    let (scene, bvh, notes) = timed(&mut seconds.load, || load_scene(options, loaded))?;
    let engine = |name| Engine64::new(name, triangles(&scene.mesh)?, bvh.clone());
    let draw =
        |engine: &Engine64| Frame::traced(&scene, size, engine, options.shadows == Shadows::Rays);
    let frame = draw(&timed(&mut seconds.build, || engine(options.engine))?)?;
    (seconds.trace, seconds.shadow) = (frame.trace_seconds, frame.shadow_seconds);

    let (width, height) = size;
    let image =
        timed(&mut seconds.shade, || shade(&scene, width, height, &frame.hits, &frame.lit))?;
    timed(&mut seconds.write, || image.write_png(&options.output))?;

    let second = |name: EngineName| -> Result<CheckReport> {
        let other = draw(&engine(name)?)?;
        let differs = Difference::bits(&frame, &other);
        let picture = options.output.with_extension("diff.png");
        differs.picture(&image).write_png(&picture)?;
        let distance = frame.largest_distance(&other, &scene, size);
        let seconds = other.trace_seconds + other.shadow_seconds;
        Ok(CheckReport::new(name, options.shadows, &differs, distance, picture, seconds))
    };
    let check = options.check.map(|name| timed(&mut seconds.check, || second(name))).transpose()?;
    seconds.total = start.elapsed().as_secs_f64();
    let report = report(options, (&scene, notes), &frame, Rounded::default(), None, seconds, check);
    print(&report, options.json)?;
    report.check.as_ref().map_or(Ok(()), refuse_differences)
}

/// Refuses options that support only f32 coordinates.
fn check(options: &Options) -> Result<()> {
    for name in [Some(options.engine), options.check].into_iter().flatten() {
        Engine64::check(name)?;
    }
    let raster = "is drawn by the rasterizer, which supports only f32 coordinates; omit it";
    if options.wire.is_some() {
        return Err(Error::usage(format!("--scalar f64: --wire {raster}")));
    }
    if options.shadows == Shadows::Volumes {
        return Err(Error::usage(format!("--scalar f64: --shadows volumes {raster}")));
    }
    Ok(())
}

/// The hierarchy of a model, if the file contains one.
type Saved = Option<Arc<Bvh<f64>>>;

/// Sets up the model or the built-in house, and applies the camera, light and texture options.
/// Reads the model unless it is already loaded.
fn load_scene(options: &Options, loaded: Option<Model>) -> Result<(Scene<f64>, Saved, ModelNotes)> {
    let _bar = Progress::new("load", None);
    let (width, height) = options.size;
    // A model's other files are never images, so the output cannot overwrite one of them.
    let load = |path| Model::load(path, options.reading);
    let loaded =
        loaded.map_or_else(|| options.model.as_deref().map(load).transpose(), |m| Ok(Some(m)));
    let model = loaded?.map(Model::in_f64).transpose()?;
    let notes = model.as_ref().map(|model| model.notes.clone()).unwrap_or_default();
    let bvh = model.as_ref().and_then(|model| model.bvh.clone());
    let aspect = f64::from(width) / f64::from(height);
    let mut scene = options.camera.scene_or(model.map(|model| model.mesh), Scene::house, aspect)?;
    cover(options, &mut scene)?;
    Ok((scene, bvh, notes))
}
