//! The report of `bench`.

use std::fmt;
use std::path::PathBuf;

use serde::Serialize;

use crate::engine::model::ModelNotes;
use crate::engine::name::EngineName;
use crate::report::phrases::{model, significant};
use crate::report::rounding::Rounded;

/// The report of `bench`.
#[derive(Serialize)]
pub(crate) struct BenchReport {
    pub(crate) model: Option<PathBuf>,
    pub(crate) triangles: usize,
    /// Everything in the model that was omitted, repaired or guessed.
    pub(crate) notes: ModelNotes,
    pub(crate) threads: usize,
    pub(crate) turns: u32,
    pub(crate) rounded: Rounded,
    pub(crate) rates: Vec<Rate>,
}

/// An engine's speed for one kind of ray, as the median over all turns.
#[derive(Serialize)]
pub(crate) struct Rate {
    pub(crate) rays: &'static str,
    pub(crate) engine: EngineName,
    /// The number of rays that were measured.
    pub(crate) count: usize,
    pub(crate) million_a_second: f64,
    pub(crate) times_the_reference: f64,
    pub(crate) hits: u64,
}

impl fmt::Display for BenchReport {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(
            f,
            "{}, {} triangles, {} threads, median of {} turns",
            model(self.model.as_deref()),
            self.triangles,
            self.threads,
            self.turns
        )?;
        self.rounded.write_line(f)?;
        write!(
            f,
            "{:10} {:10} {:>20} {:>20}",
            "rays", "engine", "million a second", "times reference"
        )?;
        for Rate { rays, engine, million_a_second, times_the_reference, .. } in &self.rates {
            let [rate, times] = [*million_a_second, *times_the_reference].map(significant);
            write!(f, "\n{rays:10} {engine:10} {rate:>20} {times:>20}")?;
        }
        Ok(())
    }
}
