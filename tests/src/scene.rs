//! A scene for the differential tests.

use intertri::{Ray, Triangle};

/// Triangles, the rays to test against them, and a threshold.
#[derive(Clone, Debug)]
pub struct Scene {
    /// The triangles.
    pub triangles: Vec<Triangle>,
    /// The rays.
    pub rays: Vec<Ray>,
    /// Document A's `Threshold`, which is finite and non-negative.
    pub threshold: f64,
}
