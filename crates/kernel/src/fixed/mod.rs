//! The mode `fixed`: exact on a grid of integers, watertight, and every crossing counted once.
//!
//! Corners and origins are snapped to integers by a power of two, and directions to integers of
//! their own length; that is the only rounding there is. What follows is integer arithmetic within
//! proven budgets, so the answers are the same bits on every CPU. The proofs are in
//! `docs/fixed-point.md`.
//!
//! A ray that meets an edge or a corner exactly is decided as if its direction were moved by
//! (e, e^2, e^3) with an e smaller than any number. So it crosses a closed mesh as a ray in general
//! position does: never through an edge, never through a corner, each surface once. A crossing lies
//! at `t > 0`: what starts on a surface does not cross it there.
//!
//! ```text
//!   f32 ── Grid ──► Ray, Triangle ──► Block, Packet, SeenTriangle ──► Crossing ──► Best ──► Hit, f64
//!          rounds     i32               f32 filter, i64        t = num / den         rounds
//! ```
//!
//! Rays and triangles that meet must come from one grid. An author of a hierarchy builds it over
//! [`Triangle::to_f32`], traverses it with [`Ray::to_f32`] and [`Best::t_hi`], and tests leaves by
//! [`Block::crossings_in`].

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

/// The widths that have integer lanes too: `Lane<4>` and `Lane<8>`.
///
/// ```
/// use intertri::fixed::{IntWidth, Packet, Prepared};
/// use intertri::simd::{Lane, Simd};
/// // Generic over the number of lanes.
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
    /// Lanes of i64.
    type I<S: Simd>: Ints;
}

impl IntWidth for Lane<4> {
    type I<S: Simd> = S::I64x4;
}
impl IntWidth for Lane<8> {
    type I<S: Simd> = S::I64x8;
}
