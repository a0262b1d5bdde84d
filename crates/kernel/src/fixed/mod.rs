//! The `fixed` mode: exact on an integer grid, watertight, and with every crossing counted once.
//!
//! Corners and origins are scaled by a power of two and snapped to integers. Directions are snapped
//! to integers at a scale of their own. Nothing else is rounded until the results are converted to
//! f64: the rest is integer arithmetic within proven bit budgets, so the results have the same bits
//! on every CPU. `docs/fixed-point.md` has the proofs.
//!
//! A ray that meets an edge or a corner exactly is decided as if its direction were moved by
//! `(e, e^2, e^3)`, with an arbitrarily small e. The ray therefore crosses a closed mesh like a ray
//! in general position: never through an edge or a corner, and through every surface once. A
//! crossing has `t > 0`, so a ray that starts on a surface does not cross it there.
//!
//! ```text
//!   f32 ─ Grid ──► Ray, Triangle ──► Block, Packet, SeenTriangle ──► Crossing ──► Best ──► Hit, f64
//!         rounds     i32               f32 filter, i64        t = num / den         rounds
//! ```
//!
//! Rays and triangles that you test against each other must come from the same grid. To use this
//! mode in your own BVH, build it over [`Triangle::to_f32`], traverse it with [`Ray::to_f32`] and
//! [`Best::t_hi`], and test its leaves with [`Block::crossings_in`].

mod block;
mod crossing;
mod determinants;
mod edges;
mod filter;
mod grid;
mod numbers;
mod packet;
mod prepared;
mod queries;
mod quotient;
mod ratio;
pub mod scalar;
mod snapped;

use crate::simd::{Ints, Simd};
use crate::simd::{Lane, Width};

pub use block::{Block, RayLanes};
pub use crossing::{Best, Crossing};
pub use grid::{Bits, Grid, GridError};
pub use packet::{Packet, SeenTriangle, Sides};
pub use prepared::Prepared;
pub use queries::{Fixed, blocks};
pub use ratio::Ratio;
pub use snapped::{Ray, Triangle};

/// The widths that also have integer lanes: `Lane<4>` and `Lane<8>`.
///
/// ```
/// use intertri::fixed::{IntWidth, Packet, Prepared};
/// use intertri::simd::{Lane, Simd};
/// // This function is generic over the number of lanes.
/// #[inline(always)]
/// fn crossed<S: Simd, const N: usize>(rays: &Packet<N>, triangle: &Prepared) -> usize
/// where
///     Lane<N>: IntWidth,
/// {
///     let mut count = 0;
///     rays.crossings_in::<S, true>(triangle, rays.live(), |_, _| count += 1);
///     count
/// }
/// ```
pub trait IntWidth: Width {
    /// Lanes of i64 integers.
    type I<S: Simd>: Ints;
}

impl IntWidth for Lane<4> {
    type I<S: Simd> = S::I64x4;
}
impl IntWidth for Lane<8> {
    type I<S: Simd> = S::I64x8;
}
