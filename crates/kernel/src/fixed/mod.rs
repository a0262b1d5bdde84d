//! The `fixed` mode: exact on an integer grid, watertight, and with every crossing counted once.
//!
//! Corners and origins are scaled by a power of two and snapped to integers. Directions are snapped
//! to integers at a scale of their own. Integers of up to 24 bits are exact in f32, so everything
//! else is the work of [`Mode::once`](crate::Mode::once), which is exact for f32 coordinates: the
//! results have the same bits on every CPU. `docs/fixed-point.md` has the proofs.
//!
//! A ray that meets an edge or a corner exactly is decided as if its direction were moved by
//! `(e, e^2, e^3)`, with an arbitrarily small e. The ray therefore crosses a closed mesh like a ray
//! in general position: never through an edge or a corner, and through every surface once. A
//! crossing has `t > 0`, so a ray that starts on a surface does not cross it there.
//!
//! ```text
//!   f32 ─ Grid ──► Ray, Triangle ──► f32 ──► Mode::once ──► Hit, f64
//!         rounds    integers        exact                   rounds t, u, v once
//! ```
//!
//! Rays and triangles that you test against each other must come from the same grid. For a
//! hierarchy, build a BVH over [`Triangle::to_f32`], trace [`Ray::to_f32`] under the *once* rule,
//! and convert t with [`Ray::t_of_caller`].

mod grid;
mod numbers;
mod queries;
mod snapped;

pub use grid::{Bits, Grid, GridError};
pub use queries::{Fixed, blocks};
pub use snapped::{Ray, Triangle};
