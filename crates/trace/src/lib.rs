//! A bounding volume hierarchy whose answers equal a plain loop's, bit for bit.

mod ahead;
mod answer;
mod batch;
mod bounds;
mod build;
mod bvh;
mod dense;
mod ends;
mod fixed;
mod flight;
mod integers;
mod leaves;
mod node;
mod pyramid;
mod questions;
#[cfg(test)]
mod random;
mod scratch;
mod screen;
mod search;
mod slab;
mod sliver;
mod spread;
mod stack;
mod tile;
mod toward;
mod trail;

pub use build::BuildError;
pub use bvh::Bvh;
pub use fixed::FixedBvh;
