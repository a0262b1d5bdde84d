//! The scenes that the checks run on.

use intertri::{Ray, Triangle};

/// Triangles, rays, and the threshold of the test, which is finite and not negative.
#[derive(Clone, Debug)]
pub struct Scene {
    /// The triangles.
    pub triangles: Vec<Triangle>,
    /// The rays.
    pub rays: Vec<Ray>,
    /// The document's `Threshold`.
    pub threshold: f64,
}
