//! The report of `build`.

use std::fmt;
use std::path::PathBuf;

use intertri_lab::tables::grouped;
use serde::Serialize;

use crate::engine::model::ModelNotes;
use crate::engine::scalar_name::ScalarName;
use crate::report::rounding::Rounded;

/// The report of `build`.
#[derive(Serialize)]
pub(crate) struct BuildReport {
    pub(crate) model: PathBuf,
    pub(crate) output: PathBuf,
    pub(crate) triangles: usize,
    /// Everything in the model that was omitted, repaired or guessed.
    pub(crate) notes: ModelNotes,
    pub(crate) scalar: ScalarName,
    pub(crate) rounded: Rounded,
    /// The size of the file, in bytes.
    pub(crate) bytes: u64,
    pub(crate) seconds: BuildSeconds,
}

/// The time of each step, in seconds.
#[derive(Default, Serialize)]
pub(crate) struct BuildSeconds {
    pub(crate) load: f64,
    pub(crate) build: f64,
    pub(crate) write: f64,
}

impl fmt::Display for BuildReport {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let triangles = grouped(self.triangles as u64);
        let scalar = self.scalar.mention();
        writeln!(f, "{triangles:>12} triangles of {}{scalar}", self.model.display())?;
        self.rounded.write_line(f)?;
        writeln!(f, "{:>12} bytes to {}", grouped(self.bytes), self.output.display())?;
        let BuildSeconds { load, build, write } = self.seconds;
        write!(f, "     seconds: load {load:.3}, build {build:.3}, write {write:.3}")
    }
}
