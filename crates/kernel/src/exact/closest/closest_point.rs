//! The closest point on a triangle: its distance and weights.

/// The point on a triangle that is closest to a given point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Closest {
    /// The distance, computed by rounding the exact squared distance to f64 and then rounding its
    /// square root. The error is at most 0.86 ulps, or 0.93 if the distance is subnormal. The
    /// result is 0 only if the true distance is 0.
    pub distance: f64,
    /// The weights of the second and third corners, each correctly rounded.
    pub weights: [f64; 2],
}
