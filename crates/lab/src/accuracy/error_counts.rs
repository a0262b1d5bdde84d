//! A method's error counts.

use serde::Serialize;

/// How often a method was wrong.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize)]
pub struct ErrorCounts {
    /// The workload.
    pub workload: &'static str,
    /// The method; [`ON_GRID`] is the mode `fixed` on inputs that snapping does not change.
    pub method: &'static str,
    /// Rays, or pairs of the mix.
    pub trials: u64,
    /// Answers that differ from the exact one. For `camera` and `secondary`: a different closest triangle, a
    /// false hit, a false miss. For `edges`: see the next two fields. For `mix`: hit or miss.
    pub wrong: u64,
    /// In `edges`: rays that leave the closed mesh without hitting it.
    pub leaks: u64,
    /// In `edges`: rays that leave it once and hit two or more triangles.
    pub doubles: u64,
    /// Answers that differ from the scalar f64 reference's: a different closest triangle, number of hits, or
    /// hit or miss.
    pub not_reference: u64,
}

/// The name of the mode `fixed` on inputs that are snapped before any method sees them.
pub const ON_GRID: &str = "fixed, on its grid";
