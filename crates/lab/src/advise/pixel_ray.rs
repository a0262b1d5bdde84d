//! The direction of a pixel's ray, with its length and its depth.

use super::vector::Vec3d;

/// A ray that starts at the eye, given by its direction.
#[derive(Clone, Copy)]
pub(super) struct PixelRay {
    pub(super) dir: Vec3d,
    pub(super) length: f64,
    /// The component of the direction along the camera's forward axis.
    pub(super) depth: f64,
}
