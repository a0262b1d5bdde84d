//! A bounding volume hierarchy whose answers equal a plain loop's, bit for bit.

mod batch;
mod bounds;
mod build;
mod bvh;
mod fixed;
mod node;
mod pyramid;
mod search;
mod slab;
mod sliver;
mod tile;

pub use build::BuildError;
pub use bvh::Bvh;
pub use fixed::FixedBvh;
