//! The closest point of a triangle: its distance and weights.

/// The point of a triangle that is closest to another.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Closest {
    /// How far it is: the root of the exact square, which is rounded once, rounded once more. That is within 0.86
    /// units of the last place of the true distance. 0 only where that is 0.
    pub distance: f64,
    /// The weights of the second and the third corner, each rounded once.
    pub weights: [f64; 2],
}
