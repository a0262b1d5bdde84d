//! Finds where methods begin to fail, by sweeping the parameters of families and by moving f64
//! walls away from the coordinate origin.

mod clearance;
mod offsets;
mod onsets;
mod sweeps;

pub use offsets::{CONTENDERS, DISTANCES, InputPrecision, OffsetErrors, sweep_offsets};
pub use onsets::{Onset, first, sweep_all};
pub use sweeps::{SWEEPS, Sweep};
