//! `intertri render`: a model, or the built-in scene, as a picture.

use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::Instant;

use clap::Args;
use intertri::fixed::Bits;
use intertri::{Threshold, Triangle};
use intertri_scene::{Image, Scene, Texture, check_output, shade};
use intertri_trace::Bvh;

use crate::commands::notes;
use crate::commands::options::{CameraOptions, LightOptions, grid_bits, threshold_of};
use crate::engine::engines::Engines;
use crate::engine::frame::{Frame, Shadows};
use crate::engine::model::load;
use crate::engine::name::EngineName;
use crate::engine::raster::{Raster, Wire};
use crate::engine::triangles::triangles;
use crate::error::{Error, Result};
use crate::io::numbers;
use crate::io::progress::{Progress, timed};
use crate::io::same_file::refuse_same_file;
use crate::report::check::Difference;
use crate::report::print::{print, tell};
use crate::report::render::{CheckReport, RenderReport, RenderSeconds};

/// Draw a model, or the built-in scene, to a PNG file
#[derive(Args)]
pub(crate) struct Options {
    /// An OBJ, PLY, STL or glTF file, or what build has saved [default: the built-in scene]
    model: Option<PathBuf>,

    /// Where the picture goes
    #[arg(short, long, value_name = "FILE", default_value = "intertri.png")]
    output: PathBuf,

    /// Pixels in a row, and rows
    #[arg(long, value_name = "WxH", default_value = "1024x768", value_parser = numbers::size)]
    size: (u32, u32),

    /// What finds the hits
    #[arg(long, value_enum, default_value_t = EngineName::Exact)]
    engine: EngineName,

    /// The bits of a coordinate on the grid of engine fixed, 1 to 20 [default: 20]
    #[arg(long, value_name = "BITS", value_parser = grid_bits, allow_hyphen_values = true)]
    grid: Option<Bits>,

    /// How to find what is in shadow
    #[arg(long, value_enum, default_value_t = Shadows::Rays)]
    shadows: Shadows,

    /// Cover the model, by its texture coordinates, with a PNG or JPEG file, or with the pattern xor;
    /// of the built-in scene, the floor and the sphere
    #[arg(long, value_name = "FILE")]
    texture: Option<PathBuf>,

    /// Draw edges over the picture where nothing hides them: of all triangles, or where the mesh turns
    /// away from the eye
    #[arg(long, value_enum, value_name = "EDGES", num_args = 0..=1, require_equals = true, default_missing_value = "mesh")]
    wire: Option<Wire>,

    /// Draw with this engine too, which finds shadows in its own way: raster by volumes, others by
    /// rays. Write a picture of where the two differ beside the output (NAME.diff.png), and fail if
    /// any pixel does that should not; those that may are light blue in the picture, the others red.
    /// Certified, double and reference must agree in triangle, bits of t, u and v, and shadow of every
    /// pixel, and so must exact and oracle. Between the three and these two, a pixel may show another
    /// triangle or shadow if exact arithmetic, asked of all triangles, says that exact is right. With
    /// raster or volumes on one side, a pixel may differ where an edge, a tie, or the border of a shadow
    /// passes within a rounding of it, as docs/raster.md derives. With fixed on one side, any pixel may
    /// show another triangle or shadow, for its scene is snapped: how many do, and how far the hits are
    /// apart, is reported
    #[arg(long, value_name = "ENGINE")]
    check: Option<EngineName>,

    /// The smallest |normal . direction| that is not parallel, and the largest t that is no hit, of
    /// engines certified, double, reference and raster [default: 1e-9]
    #[arg(long, value_name = "X", value_parser = numbers::threshold, allow_hyphen_values = true)]
    threshold: Option<Threshold>,

    /// Print a report for programs, as JSON
    #[arg(long)]
    json: bool,

    #[command(flatten)]
    camera: CameraOptions,

    #[command(flatten)]
    light: LightOptions,
}

/// Draws the picture, and checks it if asked.
pub(crate) fn run(options: &Options) -> Result<()> {
    let start = Instant::now();
    check_output(&options.output)?;
    let threshold = threshold_of(options.engine, options.threshold)?;
    let read: Vec<&Path> =
        [&options.model, &options.texture].into_iter().flatten().map(|path| &**path).collect();
    refuse_same_file(Some(&options.output), &read)?;
    let mut seconds = RenderSeconds::default();
    let (scene, triangles, bvh) = timed(&mut seconds.load, || -> Result<_> {
        let (scene, bvh) = load_scene(options)?;
        let triangles = triangles(&scene.mesh)?;
        Ok((scene, triangles, bvh))
    })?;

    // What is seen, and what is lit.
    refuse_unused_grid(options)?;
    tell_of(options, &scene, &triangles);
    let raster =
        Raster::new(&scene, &triangles, options.size, threshold.unwrap_or(Threshold::ZERO));
    let mut engines = Engines::new(&triangles, threshold.unwrap_or_default())
        .on_grid(options.grid.unwrap_or(Bits::FINE), scene.ray_origins())
        .with_bvh(bvh);
    let frame = Frame::draw(&scene, &raster, &mut engines, options.engine, options.shadows)?;
    (seconds.trace, seconds.shadow) = (frame.trace_seconds, frame.shadow_seconds);

    // The picture.
    let image = timed(&mut seconds.shade, || picture(options, &scene, &raster, &frame))?;
    timed(&mut seconds.write, || image.write_png(&options.output))?;

    // The second engine. Its hierarchy may have to be built, too.
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

    let (hits, dark) = (frame.seen(), frame.dark());
    let (up, up_given) = options.camera.up(&scene.camera);
    seconds.total = start.elapsed().as_secs_f64();
    let report = RenderReport {
        model: options.model.clone(),
        output: options.output.clone(),
        triangles: triangles.len(),
        size: options.size.into(),
        engine: options.engine,
        shadows: options.shadows,
        threshold: threshold.map(Threshold::get),
        up,
        up_given,
        rays: frame.hits.len() as u64,
        hits,
        dark,
        shadow_rays: frame.shadow_rays,
        tests: frame.counts.tests,
        undecided: frame.counts.undecided,
        grid: engines.grid(),
        seconds,
        check,
    };
    print(&report, options.json)?;
    report.check.as_ref().map_or(Ok(()), refuse_differences)
}

/// The model or the built-in scene, with its camera and texture.
fn load_scene(options: &Options) -> Result<(Scene, Option<Arc<Bvh>>)> {
    let _bar = Progress::new("load", None);
    let (width, height) = options.size;
    let model = options.model.as_deref().map(load).transpose()?;
    let bvh = model.as_ref().and_then(|model| model.bvh.clone());
    let model = model.map(|model| model.mesh);
    let mut scene = options.camera.scene(model, f64::from(width) / f64::from(height))?;
    options.light.shine_on(&mut scene)?;
    if let Some(path) = &options.texture {
        scene.texture = Some(texture(path)?);
        if scene.mesh.corner_uvs.is_none() {
            let model = options.model.as_deref().unwrap_or(Path::new("")).display();
            return Err(Error::at(model, "has no texture coordinates; leave out --texture"));
        }
    }
    Ok((scene, bvh))
}

/// A picture, or the document's pattern.
fn texture(path: &Path) -> Result<Texture> {
    if path == Path::new("xor") {
        return Ok(Texture::XOR);
    }
    Ok(Texture::load(path)?)
}

/// A grid that no engine would use is a mistake.
fn refuse_unused_grid(options: &Options) -> Result<()> {
    let is_fixed = |name| name == EngineName::Fixed;
    if options.grid.is_some() && !is_fixed(options.engine) && !options.check.is_some_and(is_fixed) {
        return Err(Error::usage(
            "--grid is for engine fixed; add --engine fixed or --check fixed",
        ));
    }
    Ok(())
}

/// Says what the picture may lose to tolerances that nobody chose.
fn tell_of(options: &Options, scene: &Scene, triangles: &[Triangle]) {
    let usual = options.engine.has_threshold() && options.threshold.is_none();
    let small = if usual { notes::small(scene, triangles) } else { None };
    // Exact shadow rays begin on the surface, whatever the way is.
    let whole = options.engine.is_exact() || options.engine == EngineName::Raster;
    let none = options.shadows == Shadows::None || options.shadows == Shadows::Rays && whole;
    let far = if none { None } else { notes::far(scene) };
    for note in [small, far].iter().flatten() {
        tell(note);
    }
}

/// The frame shaded, with edges over it if asked.
fn picture(options: &Options, scene: &Scene, raster: &Raster<'_>, frame: &Frame) -> Result<Image> {
    let (width, height) = options.size;
    let mut image = shade(scene, width, height, &frame.hits, &frame.lit)?;
    if let Some(edges) = options.wire {
        raster.draw_wire(&mut image, &frame.hits, edges)?;
    }
    Ok(image)
}

/// How the second engine finds shadows, if there are any: in its own way.
fn check_shadows(shadows: Shadows, check: EngineName) -> Shadows {
    match (shadows, check) {
        (Shadows::None, _) => Shadows::None,
        (_, EngineName::Raster) => Shadows::Volumes,
        _ => Shadows::Rays,
    }
}

/// Compares the two frames as strictly as the ways in which they were drawn allow.
fn compare(
    options: &Options,
    raster: &Raster<'_>,
    frame: &Frame,
    (name, shadows): (EngineName, Shadows),
    other: &Frame,
) -> Result<Difference> {
    let is_fixed = |name| name == EngineName::Fixed;
    let traced = |name, shadows| name != EngineName::Raster && shadows != Shadows::Volumes;
    // The same grid gives the same bits; a snapped scene is another than the one as loaded.
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

/// A difference that nothing excuses is an error.
fn refuse_differences(check: &CheckReport) -> Result<()> {
    if check.differing_pixels > check.excused_pixels {
        return Err(Error::at(
            check.picture.display(),
            format!(
                "{} pixels differ between the two engines",
                check.differing_pixels - check.excused_pixels
            ),
        ));
    }
    Ok(())
}
