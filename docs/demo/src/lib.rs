//! What `docs/demo/index.html` computes: pictures of a vertex by the known methods, a model traced by `exact`,
//! and the golden answers.
//!
//! [`exports`] is what the page calls. There is no `unsafe` here: the page writes into a buffer of this module
//! and reads from another.

pub mod exports;
pub mod fan;
mod input;
mod methods;
pub mod model;
mod tiles;

pub use methods::METHODS;
