//! `intertri inspect`: shows why a model is not closed.

use std::path::PathBuf;

use clap::Args;
use intertri_scene::Coordinate;
use intertri_trace::{BvhScalar, Solid};

use crate::engine::model::{Model, ModelIn, ModelOptions};
use crate::engine::scalar_name::ScalarName;
use crate::engine::triangles::triangles;
use crate::error::{Error, Result};
use crate::io::progress::Progress;
use crate::report::inspect::InspectReport;
use crate::report::print::print;

/// Report open edges, flipped triangles and duplicates in a model
///
/// A model has an inside if it is closed, that is, if its triangles traverse every edge equally
/// often in both directions. The report counts the edges that violate this rule and the triangles
/// that repeat others, and shows the first of each kind. With --json, it lists all of them. Corners
/// are the same if their coordinates in the model are the same.
#[derive(Args)]
pub(crate) struct Options {
    /// An OBJ, PLY, STL or glTF file, or a hierarchy saved by build
    model: PathBuf,

    #[command(flatten)]
    reading: ModelOptions,

    /// Print the report as JSON
    #[arg(long)]
    json: bool,
}

/// Loads and inspects the model.
pub(crate) fn run(options: &Options) -> Result<()> {
    let model = {
        let _bar = Progress::new("load", None);
        Model::load(&options.model, options.reading)?
    };
    if model.is_f32() {
        inspect(options, &model.in_f32()?)
    } else {
        inspect(options, &model.in_f64()?)
    }
}

/// Inspects the model in a scalar that can represent its coordinates exactly.
fn inspect<S: Coordinate + BvhScalar>(options: &Options, model: &ModelIn<S>) -> Result<()> {
    let triangles = triangles(&model.mesh).map_err(|error| error.of(&options.model))?;
    let report = Solid::inspect(&triangles);
    let report = report.map_err(|error| Error::from(error).of(&options.model))?;
    let (scalar, notes) = (ScalarName::of::<S>(), model.notes.clone());
    print(&InspectReport::new(&options.model, triangles.len(), scalar, notes, report), options.json)
}
