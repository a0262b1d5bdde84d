//! `intertri build`: saves a hierarchy as a file that can be used as a model.

use std::io;
use std::path::{Path, PathBuf};

use clap::Args;
use intertri_scene::Coordinate;
use intertri_trace::{Bvh, BvhScalar};

use crate::engine::model::{Model, ModelIn, ModelOptions};
use crate::engine::scalar_name::ScalarName;
use crate::engine::triangles::triangles;
use crate::error::{Error, Result};
use crate::io::output::Output;
use crate::io::progress::{Progress, timed};
use crate::io::same_file::refuse_same_file;
use crate::report::build::{BuildReport, BuildSeconds};
use crate::report::print::print;
use crate::report::rounding::Rounded;

/// Build the hierarchy over a model, and save it to a file
///
/// Every command accepts such a file as a model. Loading it is several times faster than building
/// the hierarchy, and checks the file. The file keeps the triangles and their numbering, but no
/// texture coordinates, colours or shared vertices. It is byte-for-byte the same on every CPU.
///
/// Coordinates are saved as f32 if f32 represents all of them exactly, and otherwise as f64.
#[derive(Args)]
pub(crate) struct Options {
    /// An OBJ, PLY, STL or glTF file, or a hierarchy saved by build
    model: PathBuf,

    /// The file to write
    #[arg(short, long, value_name = "FILE")]
    output: PathBuf,

    /// The type of the coordinates [default: that of a saved hierarchy; for other models, f32 if it
    /// represents all of them exactly, otherwise f64]
    #[arg(long, value_enum)]
    scalar: Option<ScalarName>,

    #[command(flatten)]
    reading: ModelOptions,

    /// Print the report as JSON
    #[arg(long)]
    json: bool,
}

/// Builds the hierarchy and saves it.
pub(crate) fn run(options: &Options) -> Result<()> {
    refuse_same_file(Some(&options.output), &[&options.model])?;
    let mut seconds = BuildSeconds::default();
    let model = timed(&mut seconds.load, || {
        let _bar = Progress::new("load", None);
        Model::load(&options.model, options.reading)
    })?;
    let files: Vec<&Path> = model.files.iter().map(PathBuf::as_path).collect();
    refuse_same_file(Some(&options.output), &files)?;
    let kept = if model.is_f32() { ScalarName::F32 } else { ScalarName::F64 };
    match options.scalar.unwrap_or(kept) {
        ScalarName::F32 => build(options, timed(&mut seconds.load, || model.in_f32())?, seconds),
        ScalarName::F64 => build(options, timed(&mut seconds.load, || model.in_f64())?, seconds),
    }
}

/// Builds the hierarchy in the chosen scalar, and saves it.
fn build<S: Coordinate + BvhScalar>(
    options: &Options,
    model: ModelIn<S>,
    mut seconds: BuildSeconds,
) -> Result<()> {
    let triangles = timed(&mut seconds.load, || triangles(&model.mesh));
    let triangles = triangles.map_err(|error| error.of(&options.model))?;
    let rounded = Rounded::of_model(model.rounding);
    let notes = model.notes;
    drop((model.mesh, model.bvh));
    let bar = Progress::new("build", Some(triangles.len() as u64));
    let bvh = timed(&mut seconds.build, || {
        Bvh::with_progress(&triangles, &|done, total| bar.set(done, total))
    });
    drop(bar);
    let bvh = bvh.map_err(|error| Error::from(error).of(&options.model))?;

    let mut output = Sink { output: Output::open(Some(&options.output))?, bytes: 0, error: None };
    timed(&mut seconds.write, || {
        let written = bvh.write_to(&mut output);
        match output.error.take() {
            Some(error) => Err(error),
            None => written.map_err(|error| Error::at(options.output.display(), error)),
        }
    })?;
    output.output.finish()?;
    let report = BuildReport {
        model: options.model.clone(),
        output: options.output.clone(),
        triangles: triangles.len(),
        notes,
        scalar: ScalarName::of::<S>(),
        rounded,
        bytes: output.bytes,
        seconds,
    };
    print(&report, options.json)
}

/// A writer that counts the bytes written, and keeps the output's own error, because that error
/// names the file.
struct Sink {
    output: Output,
    bytes: u64,
    error: Option<Error>,
}

impl io::Write for Sink {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.bytes += bytes.len() as u64;
        match self.output.write(bytes) {
            Ok(()) => Ok(bytes.len()),
            Err(error) => {
                self.error = Some(error);
                Err(io::ErrorKind::Other.into())
            }
        }
    }

    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}
