//! Queries over slices of any length, and the modes that define their results.

mod blocks;
mod document64;
mod exact64;
mod mode;
mod rows;
mod slice_queries;
mod slices;

pub use blocks::Blocks;
pub use mode::Mode;
pub use slice_queries::SliceScalar;
