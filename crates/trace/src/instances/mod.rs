//! Editable scenes of instances. Instances are copies of a mesh that share its tree; a matrix
//! places each of them in the world.
//!
//! ```text
//!   Scene ── add, place, show, remove ──► commit ──► SceneSnapshot ── closest, any, all, crossings
//!                                           │                      └── closest_point, classify
//!     a tree over the instances' world-space boxes, and each matrix's inverse, with error bounds
//! ```
//!
//! Triangles are tested using their world-space corners, in f64 lanes where possible and exactly
//! otherwise. The transformation to mesh space therefore affects only box tests.

mod collect;
mod committed;
mod error;
mod hit;
mod leaves;
mod matrix;
mod mesh;
mod nearest;
mod packet;
mod points;
mod saved;
mod scene;
mod snapshot;
mod top;
mod trace;
mod tree_ray;
mod world_walk;

pub use error::SceneError;
pub use hit::{InstanceId, SceneClosestPoint, SceneHit};
pub use mesh::SceneMesh;
pub use scene::Scene;
pub use snapshot::SceneSnapshot;
