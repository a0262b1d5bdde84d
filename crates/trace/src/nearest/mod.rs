//! Closest-point queries: find the closest point on the mesh to a given point.
//!
//! ```text
//!   boxes      lower bounds in f32 lanes; boxes certainly farther than a known triangle are skipped
//!   triangles  bounds in f64 lanes usually leave one triangle, or neighbours that share the point
//!   the rest   exact signs and integers determine the closest triangle, its distance, and its point
//! ```
//!
//! `docs/numerics/nearest.md` has the bounds and proofs.

mod boxes;
mod found;
mod mesh;
mod query;
mod search;
#[cfg(test)]
mod tests;

pub use found::ClosestPoint;
pub(crate) use mesh::{InF32, Mesh, QueryPoint};
pub(crate) use query::closest_points;
