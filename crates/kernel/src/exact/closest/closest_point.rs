//! The closest point of a triangle: its distance and weights.

/// The point of a triangle that is closest to another.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Closest {
    /// The distance: the root of the exact square after that is rounded, rounded again. The error is at most
    /// 0.86 units in the last place, and the result is 0 only if the true distance is.
    pub distance: f64,
    /// The weights of the second and the third corner, each correctly rounded.
    pub weights: [f64; 2],
}
