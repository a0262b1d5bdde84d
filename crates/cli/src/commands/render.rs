//! `intertri render`: draws a model, or the built-in scene, as an image.
//!
//! ```text
//!   options ──► in_f32 ────────► cover ──► any engine ──────► outcome
//!          ├──► in_f64 ────────► cover ──► exact, oracle ──┤
//!          └──► in_instances ──► cover ──► exact ──────────┘
//! ```

mod cover;
mod in_f32;
mod in_f64;
mod in_instances;
mod options;
mod outcome;

use std::path::Path;
use std::time::Instant;

use intertri_scene::check_output;

pub(crate) use self::options::Options;
use self::options::{refuse_unused_grid, takes_f32_alone, takes_instances};
use crate::commands::options::threshold_of;
use crate::engine::model::{LoadedModel, Model, saved_in};
use crate::engine::scalar_name::ScalarName;
use crate::error::Result;
use crate::io::progress::{Progress, timed};
use crate::io::same_file::refuse_same_file;

/// Draws the image, and checks it if `--check` is set.
pub(crate) fn run(options: &Options) -> Result<()> {
    let start = Instant::now();
    check_output(&options.output)?;
    let threshold = threshold_of(options.engine, options.threshold)?;
    let read: Vec<&Path> =
        [&options.model, &options.texture].into_iter().flatten().map(|path| &**path).collect();
    refuse_same_file(Some(&options.output), &read)?;
    refuse_unused_grid(options)?;
    let saved = options.model.as_deref().and_then(saved_in);
    let scalar = match options.scalar {
        Some(scalar) => scalar,
        None if takes_f32_alone(options) => ScalarName::F32,
        None => saved.unwrap_or(ScalarName::F32),
    };
    let (mut model, mut load) = (None, 0.0);
    if let (Some(path), None, true) = (&options.model, saved, takes_instances(options)) {
        let _bar = Progress::new("load", None);
        match timed(&mut load, || Model::load_shared(path, options.reading))? {
            LoadedModel::Model(one) => model = Some(*one),
            LoadedModel::Instances(instanced, notes) => {
                return in_instances::run(options, (instanced, notes), load, start);
            }
        }
    }
    match scalar {
        ScalarName::F32 => in_f32::run(options, threshold, (model, load), start),
        ScalarName::F64 => in_f64::run(options, (model, load), start),
    }
}
