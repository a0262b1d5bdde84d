//! A camera and its picture, as described by the caller.

use intertri::Ray;

/// A camera and its picture.
#[derive(Clone, Copy)]
pub struct PinholeCamera<'a> {
    /// The origin of all rays.
    pub eye: [f32; 3],
    /// Right, up, and forward, as orthogonal unit vectors.
    pub axes: [[f64; 3]; 3],
    /// Half the picture's height at distance 1.
    pub half_height: f64,
    /// The number of columns and the number of rows.
    pub size: (u32, u32),
    /// The ray of a pixel, given its column and row from the top left.
    pub ray: &'a (dyn Fn(u32, u32) -> Ray + Sync),
}

impl PinholeCamera<'_> {
    /// The angle that a pixel in the middle of the picture subtends.
    pub(super) fn pixel(&self) -> f64 {
        2.0 * self.half_height / f64::from(self.size.1)
    }
}
