//! The values that rays share when they hit the same triangle.

use crate::simd::Simd;
use crate::{Hit, Ray};

/// A triangle with the coefficients of t, u, and v for rays that share their origin or their
/// direction. The values are computed either with the document's operations or exactly. `H` is the
/// type of the result: [`Hit`] or [`Hit32`](crate::Hit32).
///
/// See [`HitCoefficients`](super::HitCoefficients) for an example.
pub trait SharedHit<H = Hit>: Copy + Default {
    /// Computes the coefficients of eight triangles. `corners[k][axis][lane]` belongs to corner
    /// k+1, and `ray` is any of the rays.
    fn eight_in<S: Simd>(
        corners: &[[[f32; 8]; 3]; 3],
        indices: &[u32; 8],
        ray: &Ray,
        to: &mut [Self; 8],
    );

    /// Writes the hit of a ray that is known to hit the triangle. Returns whether t, u, and v are
    /// certain; if they are not, call the resolver.
    fn hit_in<S: Simd>(&self, ray: &Ray, to: &mut H) -> bool;
}
