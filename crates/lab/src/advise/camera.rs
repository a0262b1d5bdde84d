//! A camera and its image, as described by the caller.

use intertri::Ray;

/// A pinhole camera and the size of its image.
#[derive(Clone, Copy)]
pub struct PinholeCamera<'a> {
    /// The origin of all rays.
    pub eye: [f32; 3],
    /// Right, up, and forward, as orthogonal unit vectors.
    pub axes: [[f64; 3]; 3],
    /// Half the height of the image on a plane at distance 1.
    pub half_height: f64,
    /// The width and height of the image in pixels.
    pub size: (u32, u32),
    /// Returns the ray for a pixel, given its column and row from the top left.
    pub ray: &'a (dyn Fn(u32, u32) -> Ray + Sync),
}

impl PinholeCamera<'_> {
    /// Returns the angle subtended by a pixel in the middle of the image.
    pub(super) fn pixel(&self) -> f64 {
        2.0 * self.half_height / f64::from(self.size.1)
    }
}
