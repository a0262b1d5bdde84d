//! The ray of a pixel.

use super::vector::Vec3d;

/// A ray from the eye.
#[derive(Clone, Copy)]
pub(super) struct PixelRay {
    pub(super) dir: Vec3d,
    pub(super) length: f64,
    /// The component of the direction into the picture.
    pub(super) depth: f64,
}
