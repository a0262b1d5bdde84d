//! The workloads, which generate batches of rays and triangles for the methods to test.

mod closed_mesh;
mod model;
mod vector;
mod workload;

pub use closed_mesh::closed_mesh;
pub use model::Model;
pub use workload::Workload;
