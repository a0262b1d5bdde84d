//! The ray of a pixel, with its length and depth.

use super::vector::Vec3d;

/// The direction of a ray from the eye, and its length.
#[derive(Clone, Copy)]
pub(super) struct PixelRay {
    pub(super) dir: Vec3d,
    pub(super) length: f64,
    /// The component of the direction along the camera's forward axis.
    pub(super) depth: f64,
}
