//! A method's error counts.

use serde::Serialize;

/// The number of wrong answers that a method gave on a workload, by kind.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize)]
pub struct ErrorCounts {
    /// The workload.
    pub workload: &'static str,
    /// The method; [`ON_GRID`] is the `fixed` mode on inputs that snapping does not change.
    pub method: &'static str,
    /// The number of rays, or of pairs for `mix`.
    pub trials: u64,
    /// The number of answers that differ from the exact answer. Wrong answers are wrong closest
    /// triangles, false hits, and false misses for `camera` and `secondary`; leaks and double hits
    /// for `edges`; and false hits and false misses for `mix`.
    pub wrong: u64,
    /// For `edges`, the number of rays that leave the closed mesh without hitting it.
    pub leaks: u64,
    /// For `edges`, the number of rays that leave the mesh once but hit two or more triangles.
    pub doubles: u64,
    /// The number of answers that differ from the scalar f64 reference in the closest triangle, in
    /// the number of hits, or in whether the ray hits.
    pub not_reference: u64,
}

/// The name of the `fixed` mode on inputs that are snapped before any method sees them.
pub const ON_GRID: &str = "fixed, on its grid";
