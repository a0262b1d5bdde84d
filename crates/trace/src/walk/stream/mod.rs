//! Ray streams: rays that have little in common, many active at once, each a step at a time.
//!
//! After the dynamic ray streams of Barringer and Akenine-Möller, *Dynamic Ray Stream Traversal* (2014),
//! in that rays are sorted by what they do next; here each keeps a stack of its own.

mod active;
mod every_hit;
mod nodes;
mod retire;
mod traverse;

pub(crate) use traverse::Stream;
