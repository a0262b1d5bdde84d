//! What users ask: queries over slices of any length, and the modes that answer them.

mod blocks;
mod in_f64;
mod mode;
mod modes;
mod rows;
mod slices;
mod which;

pub use blocks::Blocks;
pub use mode::Mode;
pub use modes::{Certified, Double, Exact};
pub use which::Which;
