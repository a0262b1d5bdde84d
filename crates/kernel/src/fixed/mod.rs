//! The mode `fixed`: exact on a grid of integers, watertight, and every crossing counted once.
//!
//! Corners and origins are snapped to integers by a power of two, and directions to integers of
//! their own length; that is the only rounding there is. What follows is integer arithmetic within
//! proven budgets, so the answers are the same bits on every CPU. The proofs are in
//! `docs/fixed-point.md`.
//!
//! A ray that meets an edge or a corner exactly is decided as if its direction were moved by
//! (e, e^2, e^3) with an e smaller than any number. So it crosses a closed mesh as a ray in general
//! position does: never through an edge, never through a corner, each surface once.

mod grid;
mod ratio;
pub mod twin;

pub use grid::{Bits, Grid, GridError, Ray, Triangle};
pub use ratio::Ratio;
