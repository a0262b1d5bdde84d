//! The ray of a pixel.

use super::vector::Vec3d;

/// A ray from the eye.
#[derive(Clone, Copy)]
pub(super) struct PixelRay {
    pub(super) dir: Vec3d,
    pub(super) length: f64,
    /// The component of the direction along the camera's forward axis.
    pub(super) depth: f64,
}
