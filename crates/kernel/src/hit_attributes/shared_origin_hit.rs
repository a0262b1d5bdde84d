//! The values that rays from one origin share when they hit the same triangle.

use crate::Hit;
use crate::simd::Simd;

/// A triangle relative to an origin, with the coefficients of t, u, and v for rays from that
/// origin. The values are computed either with the document's operations or exactly. `H` is the
/// type of the result: [`Hit`] or [`Hit32`](crate::Hit32).
///
/// See [`HitCoefficients`](super::HitCoefficients) for an example.
pub trait SharedOriginHit<H = Hit>: Copy + Default {
    /// Computes the coefficients of eight triangles. `corners[k][axis][lane]` belongs to corner
    /// k+1.
    fn eight_in<S: Simd>(
        corners: &[[[f32; 8]; 3]; 3],
        indices: &[u32; 8],
        origin: [f32; 3],
        to: &mut [Self; 8],
    );

    /// Writes the hit of a ray that is known to hit the triangle. Returns whether t, u, and v are
    /// certain; if they are not, call the resolver.
    fn hit_in<S: Simd>(&self, dir: [f32; 3], to: &mut H) -> bool;
}
