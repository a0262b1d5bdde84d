//! The computations of `docs/demo/index.html`: pictures of a vertex by the known methods, a model traced by
//! `exact`, and the golden answers.
//!
//! The page calls the functions of [`exports`]. They need no `unsafe` blocks, because the page writes to one
//! buffer of this module and reads from another.

pub mod exports;
pub mod fan;
mod input;
mod methods;
pub mod model;
mod tiles;

pub use methods::METHODS;
