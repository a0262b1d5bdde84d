//! The output of a family: a scene, or a case of one triangle and one ray.

use intertri::{Ray, Triangle};

/// Triangles and rays. Most rays hit a triangle or narrowly miss one.
#[derive(Clone, Debug, PartialEq)]
pub struct Scene {
    /// The triangles.
    pub triangles: Vec<Triangle>,
    /// The rays.
    pub rays: Vec<Ray>,
    /// The threshold of the test, finite and at least 0.
    pub threshold: f64,
}

/// One triangle and one ray.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Case {
    /// The triangle.
    pub triangle: Triangle,
    /// The ray.
    pub ray: Ray,
    /// The threshold of the test, finite and at least 0.
    pub threshold: f64,
}
