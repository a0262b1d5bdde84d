//! Beams: parallel rays whose lines are close together, traced sixteen at a time.
//!
//! ```text
//!   points ──► sorted into strips (`order.rs`) ──► sixteen in a row: a tube around their lines
//!                                                     │
//!                 nodes: one slab test of the tube ◄──┘
//!                     └──► leaves: which of eight triangles does the tube reach?
//!                              └──► which of sixteen rays? ──► intersection tests
//! ```

mod order;
#[cfg(test)]
mod tests;
mod traverse;
mod tube;
mod winding;

pub(crate) use order::order;
pub(crate) use traverse::Beams;
pub(crate) use tube::ProjectionPlane;
