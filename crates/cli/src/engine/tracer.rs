//! The interface of engines that trace rays, in f32 or in f64.

use intertri::{Counts, Crossing, Hit, RayOf};
use intertri_scene::Coordinate;

use crate::error::Result;

/// An engine that traces rays.
pub(crate) trait Tracer: Sync {
    /// The scalar of the scene and the rays.
    type Scalar: Coordinate;

    /// Returns the number of rays that a thread should trace at once, small enough that they and
    /// their answers stay in the cache.
    fn chunk_size(&self) -> usize;

    /// Returns the number of an image's rays to trace at once, large enough to keep all threads
    /// busy and small enough for the progress bar to move.
    fn batch_size(&self) -> usize {
        64 * self.chunk_size()
    }

    /// Returns whether the engine's answers are correct for the coordinates as given.
    fn is_exact(&self) -> bool;

    /// Returns the position that this engine uses for a point: `fixed` snaps points to its grid.
    fn place(&self, point: [Self::Scalar; 3]) -> [Self::Scalar; 3] {
        point
    }

    /// Returns whether rays from a point hit nothing because the point is outside the grid of
    /// `fixed`.
    fn is_outside(&self, _: [Self::Scalar; 3]) -> bool {
        false
    }

    /// Finds the closest hit of each ray. Returns zero counts in engines that do not count tests:
    /// those without a hierarchy, `fixed`, and the engine for instances.
    fn closest(&self, rays: &[RayOf<Self::Scalar>], hits: &mut [Hit]) -> Counts;

    /// Finds whether each ray hits anything. As for `closest`, some engines do not count tests.
    fn any(&self, rays: &[RayOf<Self::Scalar>], hits: &mut [bool]) -> Counts;

    /// Returns every hit of a ray, ordered by t, then by triangle.
    ///
    /// # Errors
    /// Returns an error if memory runs out.
    fn all(&self, ray: &RayOf<Self::Scalar>) -> Result<Vec<Hit>>;

    /// Returns the crossings of a ray, ordered by t, then by triangle, with each edge and corner
    /// counted once. Engines that do not support crossings return an empty list; `trace` refuses
    /// `--crossings` for these engines.
    ///
    /// # Errors
    /// Returns an error if memory runs out.
    fn crossings(&self, ray: &RayOf<Self::Scalar>) -> Result<Vec<Crossing>>;
}
