//! `intertri render` in f32, with any engine.

use std::sync::Arc;
use std::time::Instant;

use intertri::fixed::Bits;
use intertri::{Threshold, Triangle};
use intertri_scene::{Image, Rounding, Scene, shade};
use intertri_trace::Bvh;

use super::cover::cover;
use super::options::Options;
use super::outcome::{refuse_differences, report};
use crate::commands::notes;
use crate::engine::engines::Engines;
use crate::engine::frame::{Frame, Shadows};
use crate::engine::model::{Model, ModelNotes};
use crate::engine::name::EngineName;
use crate::engine::raster::Raster;
use crate::engine::triangles::triangles;
use crate::error::Result;
use crate::io::progress::{Progress, timed};
use crate::report::check::Difference;
use crate::report::print::{print, tell};
use crate::report::render::{CheckReport, RenderSeconds};
use crate::report::rounding::Rounded;

/// Draws the image, and checks it if `--check` is set. If the model is already loaded, `loaded`
/// contains it, and `load` is the time that loading took, in seconds.
pub(super) fn run(
    options: &Options,
    threshold: Option<Threshold>,
    (loaded, load): (Option<Model>, f64),
    start: Instant,
) -> Result<()> {
    let mut seconds = RenderSeconds { load, ..RenderSeconds::default() };
    let (scene, triangles, bvh, (rounding, notes)) = timed(&mut seconds.load, || -> Result<_> {
        let (scene, bvh, changes) = load_scene(options, loaded)?;
        let triangles = triangles(&scene.mesh)?;
        Ok((scene, triangles, bvh, changes))
    })?;

    // Fill the visibility buffer and the shadow mask.
    tell_of(options, &scene, &triangles);
    let raster =
        Raster::new(&scene, &triangles, options.size, threshold.unwrap_or(Threshold::ZERO));
    let mut engines = Engines::new(&triangles, threshold.unwrap_or_default())
        .on_grid(options.grid.unwrap_or(Bits::FINE), scene.ray_origins())
        .with_bvh(bvh);
    let frame = Frame::draw(&scene, &raster, &mut engines, options.engine, options.shadows)?;
    (seconds.trace, seconds.shadow) = (frame.trace_seconds, frame.shadow_seconds);

    // Shade and write the image.
    let image = timed(&mut seconds.shade, || picture(options, &scene, &raster, &frame))?;
    timed(&mut seconds.write, || image.write_png(&options.output))?;

    // Run the second engine, which may have to build its hierarchy first.
    let built = engines.seconds;
    let mut check = |name| -> Result<CheckReport> {
        let shadows = check_shadows(options.shadows, name);
        let other = Frame::draw(&scene, &raster, &mut engines, name, shadows)?;
        let differs = compare(options, &raster, &frame, (name, shadows), &other)?;
        let picture = options.output.with_extension("diff.png");
        differs.picture(&image).write_png(&picture)?;
        let distance = frame.largest_distance(&other, &scene, options.size);
        let seconds = other.trace_seconds + other.shadow_seconds;
        Ok(CheckReport::new(name, shadows, &differs, distance, picture, seconds))
    };
    let check = match options.check {
        Some(name) => Some(timed(&mut seconds.check, || check(name))?),
        None => None,
    };
    seconds.build = engines.seconds;
    seconds.check -= engines.seconds - built;

    seconds.total = start.elapsed().as_secs_f64();
    let report = report(
        options,
        (&scene, notes),
        &frame,
        Rounded::of_model(rounding),
        engines.grid(),
        seconds,
        check,
    );
    print(&report, options.json)?;
    report.check.as_ref().map_or(Ok(()), refuse_differences)
}

/// The changes made while reading a model: the rounded coordinates and the notes.
type Changes = (Rounding, ModelNotes);

/// Sets up the model or the built-in scene, and applies the camera, light and texture options.
/// Reads the model unless it is already loaded.
fn load_scene(
    options: &Options,
    loaded: Option<Model>,
) -> Result<(Scene, Option<Arc<Bvh>>, Changes)> {
    let _bar = Progress::new("load", None);
    let (width, height) = options.size;
    let load = |path| Model::load(path, options.reading);
    let loaded =
        loaded.map_or_else(|| options.model.as_deref().map(load).transpose(), |m| Ok(Some(m)));
    let model = loaded?.map(Model::in_f32).transpose()?;
    let changes = model.as_ref().map(|model| (model.rounding, model.notes.clone()));
    let changes = changes.unwrap_or_default();
    let bvh = model.as_ref().and_then(|model| model.bvh.clone());
    let model = model.map(|model| model.mesh);
    if let (Some(note), 1..) = (model.as_ref().and_then(notes::coarse), changes.0.numbers) {
        tell(&note);
    }
    let mut scene = options.camera.scene(model, f64::from(width) / f64::from(height))?;
    cover(options, &mut scene)?;
    Ok((scene, bvh, changes))
}

/// Warns if the default tolerances are too large for the scene.
fn tell_of(options: &Options, scene: &Scene, triangles: &[Triangle]) {
    let usual = options.engine.has_threshold() && options.threshold.is_none();
    let small = if usual { notes::small(scene, triangles) } else { None };
    // Exact shadow rays start on the surface, regardless of their length.
    let whole = options.engine.is_exact() || options.engine == EngineName::Raster;
    let none = options.shadows == Shadows::None || options.shadows == Shadows::Rays && whole;
    let far = if none { None } else { notes::far(scene) };
    for note in [small, far].iter().flatten() {
        tell(note);
    }
}

/// Shades the frame, and draws edges over it with `--wire`.
fn picture(options: &Options, scene: &Scene, raster: &Raster<'_>, frame: &Frame) -> Result<Image> {
    let (width, height) = options.size;
    let mut image = shade(scene, width, height, &frame.hits, &frame.lit)?;
    if let Some(edges) = options.wire {
        raster.draw_wire(&mut image, &frame.hits, edges)?;
    }
    Ok(image)
}

/// Returns the shadow method for the second engine: the engine's own method, unless shadows are
/// off.
fn check_shadows(shadows: Shadows, check: EngineName) -> Shadows {
    match (shadows, check) {
        (Shadows::None, _) => Shadows::None,
        (_, EngineName::Raster) => Shadows::Volumes,
        _ => Shadows::Rays,
    }
}

/// Compares the two frames as strictly as their methods allow.
fn compare(
    options: &Options,
    raster: &Raster<'_>,
    frame: &Frame,
    (name, shadows): (EngineName, Shadows),
    other: &Frame,
) -> Result<Difference> {
    let is_fixed = |name| name == EngineName::Fixed;
    let traced = |name, shadows| name != EngineName::Raster && shadows != Shadows::Volumes;
    // Frames on the same grid must be equal bit for bit, but a snapped scene differs from the scene
    // as loaded.
    let snapped =
        is_fixed(options.engine) != is_fixed(name) || is_fixed(name) && shadows != options.shadows;
    let both_traced = traced(options.engine, options.shadows) && traced(name, shadows);
    let _bar = Progress::new("check", None);
    Ok(match [options.engine, name].map(EngineName::is_exact) {
        _ if snapped => Difference::snapped(frame, other),
        _ if !both_traced => Difference::by_rule(raster, frame, other)?,
        [true, false] => Difference::settled(raster, frame, other),
        [false, true] => Difference::settled(raster, other, frame),
        _ => Difference::bits(frame, other),
    })
}
