//! The known ways to test a ray against a triangle, one file each, written once for any number of lanes
//! of f32 or f64.
//!
//! All are two-sided and closed: a point on an edge or vertex is inside where the method's own arithmetic
//! puts it there. All want `t > 0`, or their source's epsilon. All accept by `>=` and `>`, so that a NaN
//! is a miss. Each has its own types for what it computes once for a triangle or for a ray, so that no
//! test pays for it. No product is fused, as in the sources.
//!
//! A new method is a file with an implementation of [`Intersector`], and a line in the table
//! [`METHODS`].

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
#[cfg(feature = "measure")]
pub use table::{EXACT, METHODS, OF_THE_REFERENCE};

#[cfg(all(test, feature = "measure"))]
mod tests;
