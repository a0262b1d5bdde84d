//! The workloads: batches of rays and the triangles that they are tested against.

mod closed_mesh;
mod model;
mod vector;
mod workload;

pub use closed_mesh::closed_mesh;
pub use model::Model;
pub use workload::Workload;
