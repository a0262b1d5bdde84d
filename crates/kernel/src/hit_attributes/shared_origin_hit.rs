//! What rays from one origin share where they meet a triangle.

use crate::Hit;
use crate::simd::Simd;

/// A triangle as it is seen from one origin, ready to tell where a ray from there meets it: by the document's
/// operations, or exactly.
///
/// An example stands at [`HitCoefficients`](super::HitCoefficients).
pub trait SharedOriginHit: Copy + Default {
    /// Eight triangles: `corners[k][axis][lane]` is of corner k+1.
    fn eight_in<S: Simd>(
        corners: &[[[f32; 8]; 3]; 3],
        indices: &[u32; 8],
        origin: [f32; 3],
        to: &mut [Self; 8],
    );

    /// Where a ray that is known to hit the triangle meets it. Whether that is sure; where not, the resolver
    /// knows.
    fn hit_in<S: Simd>(&self, dir: [f32; 3], to: &mut Hit) -> bool;
}
