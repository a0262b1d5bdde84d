//! The values that rays from one origin share when they hit the same triangle.

use crate::Hit;
use crate::simd::Simd;

/// A triangle relative to one origin, with the coefficients of t, u and v for rays from there: by the
/// document's operations, or exactly. It writes an `H`: [`Hit`], or [`Hit32`](crate::Hit32).
///
/// See [`HitCoefficients`](super::HitCoefficients) for an example.
pub trait SharedOriginHit<H = Hit>: Copy + Default {
    /// Eight triangles: `corners[k][axis][lane]` is of corner k+1.
    fn eight_in<S: Simd>(
        corners: &[[[f32; 8]; 3]; 3],
        indices: &[u32; 8],
        origin: [f32; 3],
        to: &mut [Self; 8],
    );

    /// Writes the hit of a ray that is known to hit the triangle. Returns whether it is certain; if not, call the
    /// resolver.
    fn hit_in<S: Simd>(&self, dir: [f32; 3], to: &mut H) -> bool;
}
