//! The report of `trace`.

use std::fmt;
use std::path::PathBuf;

use intertri_lab::tables::grouped;
use serde::Serialize;

use crate::engine::fixed::GridReport;
use crate::engine::model::ModelNotes;
use crate::engine::name::EngineName;
use crate::engine::scalar_name::ScalarName;
use crate::report::phrases::{rate, write_grid};
use crate::report::rounding::Rounded;

/// The report of `trace`.
#[derive(Serialize)]
pub(crate) struct TraceReport {
    pub(crate) model: PathBuf,
    /// The path to the answers; null for standard output.
    pub(crate) output: Option<PathBuf>,
    pub(crate) triangles: usize,
    /// Everything in the model that was omitted, repaired or guessed.
    pub(crate) notes: ModelNotes,
    pub(crate) engine: EngineName,
    /// The scalar that the model and the rays were traced in.
    pub(crate) scalar: ScalarName,
    pub(crate) rounded: Rounded,
    /// The threshold; null if the engine has none.
    pub(crate) threshold: Option<f64>,
    pub(crate) rays: u64,
    /// The number of rays that hit something.
    pub(crate) hits: u64,
    /// The number of rays that count as misses because they start outside the grid of the `fixed`
    /// engine.
    pub(crate) outside: u64,
    /// The grid of the `fixed` engine, if it was used.
    pub(crate) grid: Option<GridReport>,
    pub(crate) seconds: TraceSeconds,
}

/// The time of each step, in seconds. For `trace`, it is the working time per thread. The last
/// three steps overlap.
#[derive(Default, Serialize)]
pub(crate) struct TraceSeconds {
    pub(crate) load: f64,
    pub(crate) build: f64,
    pub(crate) read: f64,
    pub(crate) trace: f64,
    pub(crate) write: f64,
}

impl fmt::Display for TraceReport {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (rays, hits) = (grouped(self.rays), grouped(self.hits));
        let triangles = grouped(self.triangles as u64);
        writeln!(f, "{triangles:>12} triangles of {}", self.model.display())?;
        let rate = rate(self.rays, self.seconds.trace);
        writeln!(f, "{rays:>12} rays, {rate}, engine {}{}", self.engine, self.scalar.mention())?;
        writeln!(f, "{hits:>12} of them hit something")?;
        self.rounded.write_line(f)?;
        write_grid(f, self.grid)?;
        let TraceSeconds { load, build, read, trace, write } = self.seconds;
        write!(
            f,
            "     seconds: load {load:.3}, build {build:.3}, read {read:.3}, trace {trace:.3}, \
             write {write:.3}"
        )
    }
}
