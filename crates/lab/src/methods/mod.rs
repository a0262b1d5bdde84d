//! The known ray/triangle tests. Each has its own file and is written once, for any number of f32
//! or f64 lanes.
//!
//! All tests are two-sided and closed: a point that the method's own arithmetic puts on an edge or
//! vertex is inside. All require `t > 0` or, if the original method has a threshold, `t` above the
//! threshold. All accept hits only with comparisons that are false for NaN, so a NaN results in a
//! miss. Each method has its own types for the values that it computes once per triangle or ray. As
//! in the original publications, multiply-adds are not fused.
//!
//! To add a method, write a file with an implementation of [`Intersector`] and add a row to the
//! table [`METHODS`].

mod axis;
pub mod badouel;
pub mod baldwin_weber;
#[cfg(feature = "measure")]
mod closest;
pub mod cramer;
pub mod embree;
#[cfg(feature = "measure")]
mod fixed;
pub mod inter_tri;
mod intersector;
#[cfg(feature = "measure")]
mod kernel;
#[cfg(feature = "measure")]
mod method;
pub mod moller_trumbore;
#[cfg(feature = "measure")]
mod one_origin;
#[cfg(feature = "measure")]
mod pairs;
pub mod pluecker;
mod real;
#[cfg(feature = "measure")]
mod reference;
pub mod signed_volume;
#[cfg(feature = "measure")]
mod table;
pub mod woop;

#[cfg(feature = "measure")]
pub use fixed::on_grid;
pub use intersector::{Intersector, PlainRay};
#[cfg(feature = "measure")]
pub use method::Method;
pub use real::{Number, Real};
#[cfg(feature = "measure")]
pub use reference::reference_closest;
#[cfg(all(test, feature = "draw"))]
pub(crate) use table::FIXED;
#[cfg(feature = "measure")]
pub use table::{EXACT, METHODS, OF_THE_REFERENCE};
