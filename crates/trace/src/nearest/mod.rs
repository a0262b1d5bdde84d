//! The point of the mesh that is closest to a given one.
//!
//! ```text
//!   boxes      f32 lanes, from below: what is surely farther than something found is left out
//!   triangles  f64 lanes, from below and above: nearly always one remains, or neighbours that share the point
//!   the rest   exact signs and integers: which is closest, how far, and where
//! ```
//!
//! Bounds and proofs: `docs/numerics/nearest.md`.

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
