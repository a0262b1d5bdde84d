//! Where methods begin to fail: families swept by their parameter.

mod clearance;
mod onsets;
mod sweeps;

pub use onsets::{Onset, first, sweep_all};
pub use sweeps::{SWEEPS, Sweep};
