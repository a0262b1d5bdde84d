//! What `intertri render` is asked.

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
    /// An OBJ, PLY, STL or glTF file, or what build has saved [default: the built-in scene]
    pub(super) model: Option<PathBuf>,

    /// Where the picture goes
    #[arg(short, long, value_name = "FILE", default_value = "intertri.png")]
    pub(super) output: PathBuf,

    /// Pixels in a row, and rows
    #[arg(long, value_name = "WxH", default_value = "1024x768", value_parser = numbers::size)]
    pub(super) size: (u32, u32),

    /// What finds the hits
    #[arg(long, value_enum, default_value_t = EngineName::Exact)]
    pub(super) engine: EngineName,

    /// What the model is traced in; f64 is for engines exact and oracle, which --check may name, too.
    /// Without a model it draws a house at UTM coordinates. In f32 coordinates are rounded, which a picture
    /// hardly shows; the report says how many [default: what build saved it in, else f32]
    #[arg(long, value_enum)]
    pub(super) scalar: Option<ScalarName>,

    /// The bits of a coordinate on the grid of engine fixed, 1 to 20 [default: 20]
    #[arg(long, value_name = "BITS", value_parser = grid_bits, allow_hyphen_values = true)]
    pub(super) grid: Option<Bits>,

    /// How to find what is in shadow
    #[arg(long, value_enum, default_value_t = Shadows::Rays)]
    pub(super) shadows: Shadows,

    /// Cover the model, by its texture coordinates, with a PNG or JPEG file, or with the pattern xor;
    /// of the built-in scene, the floor and the sphere
    #[arg(long, value_name = "FILE")]
    pub(super) texture: Option<PathBuf>,

    /// Draw edges over the picture where nothing hides them: of all triangles, or where the mesh turns
    /// away from the eye
    #[arg(long, value_enum, value_name = "EDGES", num_args = 0..=1, require_equals = true, default_missing_value = "mesh")]
    pub(super) wire: Option<Wire>,

    /// Draw with this engine too, which finds shadows in its own way: raster by volumes, others by
    /// rays. Write a picture of where the two differ beside the output (NAME.diff.png), and fail if
    /// any pixel does that should not; those that may are light blue in the picture, the others red.
    /// Certified and reference must agree in triangle, bits of t, u and v, and shadow of every
    /// pixel, and so must exact and oracle. Between the three and these two, a pixel may show another
    /// triangle or shadow if exact arithmetic, asked of all triangles, says that exact is right. With
    /// raster or volumes on one side, a pixel may differ where an edge, a tie, or the border of a shadow
    /// passes within a rounding of it, as docs/raster.md derives. With fixed on one side, any pixel may
    /// show another triangle or shadow, for its scene is snapped: how many do, and how far the hits are
    /// apart, is reported
    #[arg(long, value_name = "ENGINE")]
    pub(super) check: Option<EngineName>,

    /// The smallest |normal . direction| that is not parallel, and the largest t that is no hit, of
    /// engines certified, reference and raster [default: 1e-9]
    #[arg(long, value_name = "X", value_parser = numbers::threshold, allow_hyphen_values = true)]
    pub(super) threshold: Option<Threshold>,

    #[command(flatten)]
    pub(super) reading: ModelOptions,

    /// Print a report for programs, as JSON
    #[arg(long)]
    pub(super) json: bool,

    #[command(flatten)]
    pub(super) camera: CameraOptions,

    #[command(flatten)]
    pub(super) light: LightOptions,
}

/// Whether something is asked for that takes coordinates in f32 alone.
pub(super) fn takes_f32_alone(options: &Options) -> bool {
    let engines = [Some(options.engine), options.check];
    engines.into_iter().flatten().any(|engine| !engine.is_exact())
        || options.wire.is_some()
        || options.shadows == Shadows::Volumes
}

/// A grid that no engine would use is a mistake.
pub(super) fn refuse_unused_grid(options: &Options) -> Result<()> {
    let is_fixed = |name| name == EngineName::Fixed;
    if options.grid.is_some() && !is_fixed(options.engine) && !options.check.is_some_and(is_fixed) {
        return Err(Error::usage(
            "--grid is for engine fixed; add --engine fixed or --check fixed",
        ));
    }
    Ok(())
}
