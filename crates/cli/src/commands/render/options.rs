//! The options of `intertri render`.

use std::path::PathBuf;

use clap::Args;
use intertri::Threshold;
use intertri::fixed::Bits;

use crate::commands::options::{CameraOptions, LightOptions, grid_bits};
use crate::engine::frame::Shadows;
use crate::engine::model::ModelOptions;
use crate::engine::name::EngineName;
use crate::engine::raster::Wire;
use crate::engine::scalar_name::ScalarName;
use crate::error::{Error, Result};
use crate::io::numbers;

/// Draw a model, or the built-in scene, to a PNG file
#[derive(Args)]
pub(crate) struct Options {
    /// An OBJ, PLY, STL or glTF file, or a hierarchy saved by build [default: the built-in scene]
    pub(super) model: Option<PathBuf>,

    /// The file to write
    #[arg(short, long, value_name = "FILE", default_value = "intertri.png")]
    pub(super) output: PathBuf,

    /// The width and height in pixels
    #[arg(long, value_name = "WxH", default_value = "1024x768", value_parser = numbers::size)]
    pub(super) size: (u32, u32),

    /// The engine that finds the hits
    #[arg(long, value_enum, default_value_t = EngineName::Exact)]
    pub(super) engine: EngineName,

    /// The scalar to trace in; f64 works only with the exact and oracle engines, also for --check.
    /// Without a model, f64 draws a house at UTM coordinates. f32 rounds coordinates, which is
    /// hardly visible in a picture; the report counts the rounded numbers [default: that of a saved
    /// hierarchy; f64 for a glTF file whose nodes share meshes, which are then traced as instances;
    /// otherwise f32]
    #[arg(long, value_enum)]
    pub(super) scalar: Option<ScalarName>,

    /// The number of bits per coordinate on the grid of the fixed engine, 1 to 20 [default: 20]
    #[arg(long, value_name = "BITS", value_parser = grid_bits, allow_hyphen_values = true)]
    pub(super) grid: Option<Bits>,

    /// How to find shadows
    #[arg(long, value_enum, default_value_t = Shadows::Rays)]
    pub(super) shadows: Shadows,

    /// Texture the model, through its texture coordinates, with a PNG or JPEG file or with the
    /// pattern xor; in the built-in scene, texture the floor and the sphere
    #[arg(long, value_name = "FILE")]
    pub(super) texture: Option<PathBuf>,

    /// Draw visible edges over the picture: all edges, or only the silhouette
    #[arg(long, value_enum, value_name = "EDGES", num_args = 0..=1, require_equals = true, default_missing_value = "mesh")]
    pub(super) wire: Option<Wire>,

    /// Also draw with this engine, which finds shadows with its own method: raster with volumes,
    /// the others with rays. Write a picture of the differences next to the output (NAME.diff.png),
    /// and fail if a pixel differs that must not. In this picture, pixels that may differ are light
    /// blue, and all other differing pixels are red. Certified and reference must agree on the
    /// triangle, the bits of t, u and v, and the shadow of every pixel, and so must exact and
    /// oracle. Between these two pairs, a pixel may show another triangle or shadow if exact
    /// arithmetic over all triangles confirms exact. If either engine uses raster or volumes, a
    /// pixel may differ if an edge, a tie, or the border of a shadow passes within rounding error
    /// of it, as docs/raster.md derives. If either engine is fixed, any pixel may show another
    /// triangle or shadow, because its scene is snapped; the report states how many do, and how far
    /// apart the hits are
    #[arg(long, value_name = "ENGINE")]
    pub(super) check: Option<EngineName>,

    /// The smallest |normal . direction| that does not count as parallel, and the largest t that
    /// does not count as a hit, for the certified, reference and raster engines [default: 1e-9]
    #[arg(long, value_name = "X", value_parser = numbers::threshold, allow_hyphen_values = true)]
    pub(super) threshold: Option<Threshold>,

    #[command(flatten)]
    pub(super) reading: ModelOptions,

    /// Print the report as JSON
    #[arg(long)]
    pub(super) json: bool,

    #[command(flatten)]
    pub(super) camera: CameraOptions,

    #[command(flatten)]
    pub(super) light: LightOptions,
}

/// Returns whether an option or engine supports only f32 coordinates.
pub(super) fn takes_f32_alone(options: &Options) -> bool {
    let engines = [Some(options.engine), options.check];
    engines.into_iter().flatten().any(|engine| !engine.is_exact())
        || options.wire.is_some()
        || options.shadows == Shadows::Volumes
}

/// Returns whether these options allow a model with shared meshes to be traced as instances. This
/// requires the `exact` engine and f64, and excludes `--check`.
pub(super) fn takes_instances(options: &Options) -> bool {
    options.engine == EngineName::Exact
        && options.check.is_none()
        && options.scalar != Some(ScalarName::F32)
        && !takes_f32_alone(options)
}

/// Refuses a grid option that no engine would use.
pub(super) fn refuse_unused_grid(options: &Options) -> Result<()> {
    let is_fixed = |name| name == EngineName::Fixed;
    if options.grid.is_some() && !is_fixed(options.engine) && !options.check.is_some_and(is_fixed) {
        return Err(Error::usage(
            "--grid is only for the fixed engine; add --engine fixed or --check fixed",
        ));
    }
    Ok(())
}
