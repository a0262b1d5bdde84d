//! Ray streams for incoherent rays: many rays are active at once, and each advances one step at a
//! time.
//!
//! Rays are grouped by the kind of step they take next, as in Barringer and Akenine-Möller,
//! *Dynamic Ray Stream Traversal* (2014). Unlike there, each ray has its own stack.

mod active;
mod every_hit;
mod nodes;
mod retire;
mod traverse;

pub(crate) use retire::Retired;
pub(crate) use traverse::Stream;
