//! The arithmetics that are compared, and how far snapping to a grid moves points.

/// An arithmetic.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Arithmetic {
    /// The reference's f64, with a threshold.
    Double {
        /// Document A's `Threshold`.
        threshold: f64,
    },
    /// Möller and Trumbore's test in f32, products not fused, without an epsilon.
    Single,
    /// Integers.
    Grid {
        /// The distance of neighbouring points of the grid.
        step: f64,
        /// The bits of a direction.
        q: u32,
    },
}

/// How far a side and a ray, together, may move.
pub(super) fn moves(arithmetic: Arithmetic, reach: f64) -> f64 {
    match arithmetic {
        Arithmetic::Grid { step, q } => snap(step) + turn(q) * reach,
        _ => 0.0,
    }
}

/// How far a point moves when it is snapped: half a step along each axis.
pub(super) fn snap_of_one(step: f64) -> f64 {
    0.75_f64.sqrt() * step
}

/// How far a corner moves as seen from the eye, which moves, too.
pub(super) fn snap(step: f64) -> f64 {
    2.0 * snap_of_one(step)
}

/// The angle by which a direction turns when it is snapped.
pub(super) fn turn(q: u32) -> f64 {
    1.01 * 3.0_f64.sqrt() / f64::from(1_u32 << q)
}
