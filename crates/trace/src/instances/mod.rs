//! Scenes of instances: meshes that share a tree, each placed in the world by a matrix. Scenes can
//! be edited.
//!
//! ```text
//!   Scene ── add, place, show, remove ──► commit ──► SceneSnapshot ── closest, any, all, crossings
//!                                           │                      └── closest_point, classify
//!     a tree of instances over world-space boxes, and an inverse of each matrix, with error bounds
//! ```
//!
//! Triangles are tested in world space, at the corners that the scene defines: in f64 lanes, and
//! exactly where f64 cannot decide. The transformation to mesh space therefore only affects boxes.

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
