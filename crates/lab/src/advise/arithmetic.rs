//! The kinds of arithmetic to compare, and bounds on how far snapping to a grid moves points.

/// A kind of arithmetic.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Arithmetic {
    /// The f64 arithmetic of the reference, with a threshold.
    Double {
        /// Document A's `Threshold`.
        threshold: f64,
    },
    /// The Möller–Trumbore test in f32, without fused products or an epsilon.
    Single,
    /// Integers on a grid.
    Grid {
        /// The distance between neighbouring grid points.
        step: f64,
        /// The number of bits per component of a direction.
        q: u32,
    },
}

/// Returns how far a triangle's side and a ray may move relative to each other with the given
/// arithmetic.
pub(super) fn moves(arithmetic: Arithmetic, reach: f64) -> f64 {
    match arithmetic {
        Arithmetic::Grid { step, q } => snap(step) + turn(q) * reach,
        _ => 0.0,
    }
}

/// Returns how far a point may move when it is snapped: up to half a step along each axis.
pub(super) fn snap_of_one(step: f64) -> f64 {
    0.75_f64.sqrt() * step
}

/// Returns how far a corner may move relative to the eye if both are snapped.
pub(super) fn snap(step: f64) -> f64 {
    2.0 * snap_of_one(step)
}

/// Returns the largest angle by which snapping can turn a direction.
pub(super) fn turn(q: u32) -> f64 {
    1.01 * 3.0_f64.sqrt() / f64::from(1_u32 << q)
}
