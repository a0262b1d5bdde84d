//! Counts how often each method's answers to a workload differ from those of the oracle and of the
//! reference.

mod closed_mesh;
mod closest;
mod error_counts;
mod pairs;
mod workload;

pub(crate) use closed_mesh::{is_within, leaks_and_doubles};
pub use error_counts::{ErrorCounts, ON_GRID};
pub use workload::count_errors;
