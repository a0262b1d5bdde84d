//! The computations behind `docs/demo/index.html`: images of a vertex and of a model, traced with
//! `exact` and with well-known methods, and the golden results.
//!
//! The page calls the functions in [`exports`]. They do not need `unsafe` blocks, because they do
//! not take pointers: the page writes to one buffer of this module and reads from another.

pub mod exports;
pub mod fan;
mod input;
mod methods;
pub mod model;
mod tiles;

pub use methods::METHODS;
