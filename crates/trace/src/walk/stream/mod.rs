//! Traces incoherent rays as streams: 64 rays are active at once, and in each round, every active
//! ray advances by one node or one leaf.
//!
//! Each round first handles all rays that are at a leaf, then all rays that are at a node.
//! Barringer and Akenine-Möller, *Dynamic Ray Stream Traversal* (2014), also advance many rays
//! together, but sort them at each node. Here, each ray has its own stack instead.

mod active;
mod every_hit;
mod nodes;
mod retire;
mod traverse;

pub(crate) use retire::Retired;
pub(crate) use traverse::Stream;
