//! Ray streams: incoherent rays, many active at once, each advancing one step at a time.
//!
//! Like the dynamic ray streams of Barringer and Akenine-Möller, *Dynamic Ray Stream Traversal* (2014), this
//! sorts rays by what they do next; here, each ray has its own stack.

mod active;
mod every_hit;
mod nodes;
mod retire;
mod traverse;

pub(crate) use retire::Retired;
pub(crate) use traverse::Stream;
