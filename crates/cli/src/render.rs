//! `intertri render`: a model, or the built-in scene, as a picture.

use std::path::{Path, PathBuf};

use clap::{Args, ValueEnum};
use intertri::Threshold;
use intertri::fixed::Bits;
use intertri_scene::{Texture, check_output, load, shade};
use serde::Serialize;

use crate::camera;
use crate::check::Difference;
use crate::engine::{self, Engines};
use crate::error::{Error, Result};
use crate::fixed::parse_bits;
use crate::frame::Frame;
use crate::numbers;
use crate::progress::{Progress, timed};
use crate::raster::Raster;
use crate::report::{self, Check, Render};

/// Draw a model, or the built-in scene, to a PNG file
#[derive(Args)]
pub(crate) struct Options {
    /// An OBJ, PLY or STL file [default: the built-in scene]
    model: Option<PathBuf>,

    /// Where the picture goes
    #[arg(short, long, value_name = "FILE", default_value = "intertri.png")]
    output: PathBuf,

    /// Pixels in a row, and rows
    #[arg(long, value_name = "WxH", default_value = "1024x768", value_parser = numbers::size)]
    size: (u32, u32),

    /// What finds the hits
    #[arg(long, value_enum, default_value_t = engine::Name::Certified)]
    engine: engine::Name,

    /// The bits of a coordinate on the grid of engine fixed, 1 to 20 [default: 20]
    #[arg(long, value_name = "BITS", value_parser = parse_bits, allow_hyphen_values = true)]
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
    /// any pixel does that should not. Of engines that trace, every pixel must have the same triangle,
    /// bits of t, and shadow. With raster or volumes on one side, a pixel may differ where an edge, a
    /// tie, or the border of a shadow passes within a rounding of it (light blue in the picture, not
    /// red), as docs/raster.md derives. With fixed on one side, any pixel may show another triangle or
    /// shadow, for its scene is snapped: how many do, and how far the hits are apart, is reported
    #[arg(long, value_name = "ENGINE")]
    check: Option<engine::Name>,

    /// The smallest |normal . direction| that is not parallel, and the largest t that is no hit
    #[arg(long, value_name = "X", value_parser = numbers::threshold, default_value = "1e-9", allow_hyphen_values = true)]
    threshold: Threshold,

    /// Print a report for programs, as JSON
    #[arg(long)]
    json: bool,

    #[command(flatten)]
    camera: camera::Options,
}

/// How the shadow mask is made.
#[derive(Clone, Copy, PartialEq, Eq, ValueEnum, Serialize)]
#[serde(rename_all = "lowercase")]
pub(crate) enum Shadows {
    /// A ray from the light to each point that is seen; those of engine raster are certified
    Rays,
    /// Counting the volumes of shadow that each point is in: no rays
    Volumes,
    /// Everything is lit
    None,
}

/// Which edges are drawn.
#[derive(Clone, Copy, PartialEq, Eq, ValueEnum, Serialize)]
#[serde(rename_all = "lowercase")]
pub(crate) enum Wire {
    /// Those of all triangles
    Mesh,
    /// Those where the mesh turns away from the eye, or ends
    Silhouette,
}

/// Draws.
pub(crate) fn run(options: &Options) -> Result<()> {
    let (width, height) = options.size;
    check_output(&options.output)?;
    let mut seconds = report::Seconds::default();

    // The scene.
    let scene = timed(&mut seconds.load, || -> Result<_> {
        let _bar = Progress::new("load", None);
        let model = options.model.as_deref().map(load).transpose()?;
        let mut scene = options.camera.scene(model, f64::from(width) / f64::from(height))?;
        if let Some(path) = &options.texture {
            scene.texture = Some(texture(path)?);
            if scene.mesh.corner_uvs.is_none() {
                let model = options.model.as_deref().unwrap_or(Path::new("")).display();
                return Err(Error::at(model, "has no texture coordinates; leave out --texture"));
            }
        }
        Ok(scene)
    })?;
    let triangles = scene.mesh.to_triangles();

    // What is seen, and what is lit.
    let raster = Raster::new(&scene, &triangles, options.size, options.threshold);
    let is_fixed = |name| name == engine::Name::Fixed;
    if options.grid.is_some() && !is_fixed(options.engine) && !options.check.is_some_and(is_fixed) {
        return Err(Error::new("--grid is for engine fixed; add --engine fixed or --check fixed"));
    }
    let from = vec![scene.camera.eye(), scene.light.position];
    let mut engines = Engines::new(&triangles, options.threshold)
        .on_grid(options.grid.unwrap_or(Bits::FINE), from);
    let frame = Frame::draw(&scene, &raster, &mut engines, options.engine, options.shadows)?;
    seconds.build = engines.seconds;
    (seconds.trace, seconds.shadow) = (frame.trace, frame.shadow);

    // The picture.
    let mut image =
        timed(&mut seconds.shade, || shade(&scene, width, height, &frame.hits, &frame.lit))?;
    if let Some(edges) = options.wire {
        timed(&mut seconds.shade, || raster.draw_wire(&mut image, &frame.hits, edges))?;
    }
    timed(&mut seconds.write, || image.write_png(&options.output))?;

    // The same again, if somebody doubts it.
    let check = match options.check {
        None => None,
        Some(name) => {
            let shadows = match (options.shadows, name) {
                (Shadows::None, _) => Shadows::None,
                (_, engine::Name::Raster) => Shadows::Volumes,
                _ => Shadows::Rays,
            };
            let other = Frame::draw(&scene, &raster, &mut engines, name, shadows)?;
            let traced =
                |engine, shadows| engine != engine::Name::Raster && shadows != Shadows::Volumes;
            // The same grid has the same bits; another scene has its own.
            let snapped = is_fixed(options.engine) != is_fixed(name)
                || is_fixed(name) && shadows != options.shadows;
            let differs = if snapped {
                Difference::snapped(&frame, &other)
            } else if traced(options.engine, options.shadows) && traced(name, shadows) {
                Difference::bits(&frame, &other)
            } else {
                let _bar = Progress::new("check", None);
                Difference::by_rule(&raster, &frame, &other)?
            };
            let picture = options.output.with_extension("diff.png");
            differs.picture(&image).write_png(&picture)?;
            let apart = frame.apart(&other, &scene, options.size);
            Some(Check::new(name, shadows, &differs, apart, picture, other.trace + other.shadow))
        }
    };

    let report = Render {
        model: options.model.clone(),
        output: options.output.clone(),
        triangles: triangles.len(),
        size: [width, height],
        engine: options.engine,
        shadows: options.shadows,
        threshold: options.threshold.get(),
        rays: frame.hits.len() as u64,
        hits: frame.hits.iter().filter(|hit| hit.is_hit()).count() as u64,
        dark: frame.lit.iter().filter(|lit| !**lit).count() as u64,
        shadow_rays: frame.shadow_rays,
        tests: frame.counts.tests,
        undecided: frame.counts.undecided,
        grid: engines.grid(),
        seconds,
        check,
    };
    report::print(&report, options.json)?;
    match report.check {
        Some(check) if check.differing_pixels > check.excused_pixels => Err(Error::at(
            check.picture.display(),
            format!(
                "{} pixels differ between the two engines",
                check.differing_pixels - check.excused_pixels
            ),
        )),
        _ => Ok(()),
    }
}

/// A picture, or the document's pattern.
fn texture(path: &Path) -> Result<Texture> {
    if path == Path::new("xor") {
        return Ok(Texture::Xor { texels: 256 });
    }
    Ok(Texture::load(path)?)
}
