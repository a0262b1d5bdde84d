//! A bounding volume hierarchy whose answers equal a plain loop's, bit for bit.

mod batch;
mod bounds;
mod build;
mod bvh;
mod node;
mod search;
mod slab;
mod sliver;

pub use build::BuildError;
pub use bvh::Bvh;
