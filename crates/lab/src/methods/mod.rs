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
mod closest;
pub mod cramer;
pub mod embree;
mod fixed;
pub mod inter_tri;
mod intersector;
mod kernel;
mod method;
pub mod moller_trumbore;
mod one_origin;
mod pairs;
pub mod pluecker;
mod real;
mod reference;
pub mod signed_volume;
mod table;
pub mod woop;

pub use fixed::on_grid;
pub use intersector::{Intersector, PlainRay};
pub use method::Method;
pub use real::{Number, Real};
pub use reference::reference_closest;
pub use table::{EXACT, METHODS, OF_THE_REFERENCE};

#[cfg(test)]
mod tests;
