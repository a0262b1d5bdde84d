//! The interface of engines that trace rays, in f32 or in f64.

use intertri::{Counts, Crossing, Hit, RayOf};
use intertri_scene::Coordinate;

use crate::error::Result;

/// An engine that answers rays.
pub(crate) trait Tracer: Sync {
    /// The scalar of its scene and its rays.
    type Scalar: Coordinate;

    /// How many rays a thread should trace at once: few enough that they and their answers stay in the cache.
    fn chunk_size(&self) -> usize;

    /// How many rays of a picture to trace at once: enough for all threads, few enough for the progress bar
    /// to move.
    fn batch_size(&self) -> usize {
        64 * self.chunk_size()
    }

    /// Whether its answers are right for the coordinates as given.
    fn is_exact(&self) -> bool;

    /// The position of a point for this engine: `fixed` snaps it to its grid.
    fn place(&self, point: [Self::Scalar; 3]) -> [Self::Scalar; 3] {
        point
    }

    /// Whether rays from a point hit nothing because it is outside the grid of `fixed`.
    fn is_outside(&self, _: [Self::Scalar; 3]) -> bool {
        false
    }

    /// The closest hit of each ray. Only engines with a hierarchy count tests, and `fixed` does not.
    fn closest(&self, rays: &[RayOf<Self::Scalar>], hits: &mut [Hit]) -> Counts;

    /// Whether each ray hits anything; counts like `closest`.
    fn any(&self, rays: &[RayOf<Self::Scalar>], hits: &mut [bool]) -> Counts;

    /// Every hit of a ray, in order of t; if two have the same t, in order of the triangles.
    ///
    /// # Errors
    /// Fails if there is too little memory for them.
    fn all(&self, ray: &RayOf<Self::Scalar>) -> Result<Vec<Hit>>;

    /// The crossings of a ray, with each edge and corner counted once, in order of t, then of triangles.
    /// Empty for engines without crossings, which `trace` refuses.
    ///
    /// # Errors
    /// Fails if there is too little memory for them.
    fn crossings(&self, ray: &RayOf<Self::Scalar>) -> Result<Vec<Crossing>>;
}
