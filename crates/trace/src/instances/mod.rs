//! Instances: meshes that share a tree, each placed in the world by a matrix, in scenes that can change.
//!
//! ```text
//!   Scene ── add, place, show, remove ──► commit ──► SceneSnapshot ── closest, any, all, crossings
//!                                           │                      └── closest_point, classify
//!     tree of instances over boxes in the world, an inverse of each matrix with its bounds
//! ```
//!
//! Triangles are tested at the world coordinates that the definition gives their corners, in f64 lanes, and
//! exactly where these cannot decide. So the transformation to mesh space only affects boxes.

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
