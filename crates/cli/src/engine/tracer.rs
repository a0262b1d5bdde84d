//! What answers rays, whatever they are given in.

use intertri::{Counts, Crossing, Hit, RayOf};
use intertri_scene::Coordinate;

/// Something that answers rays.
pub(crate) trait Tracer: Sync {
    /// What coordinates of its scene and its rays are given in.
    type Scalar: Coordinate;

    /// How many rays a thread should ask at once: few enough that they and their answers stay in the
    /// cache.
    fn chunk_size(&self) -> usize;

    /// How many rays of a picture to ask at once: enough for all threads, few enough for a bar to move.
    fn batch_size(&self) -> usize {
        64 * self.chunk_size()
    }

    /// Whether its answers are right on the coordinates as given.
    fn is_exact(&self) -> bool;

    /// Where a point is for this engine: `fixed` has it on its grid.
    fn place(&self, point: [Self::Scalar; 3]) -> [Self::Scalar; 3] {
        point
    }

    /// Whether rays that start at a point hit nothing because it is outside of the grid of `fixed`.
    fn is_outside(&self, _: [Self::Scalar; 3]) -> bool {
        false
    }

    /// The closest hit of each ray. Only what walks a hierarchy counts its tests, and `fixed` does not.
    fn closest(&self, rays: &[RayOf<Self::Scalar>], hits: &mut [Hit]) -> Counts;

    /// Whether each ray hits anything; the same of its counts.
    fn any(&self, rays: &[RayOf<Self::Scalar>], hits: &mut [bool]) -> Counts;

    /// Every hit of a ray, in order of t; of equal t, of the triangles.
    fn all(&self, ray: &RayOf<Self::Scalar>) -> Vec<Hit>;

    /// Where a ray crosses, each edge and corner once, in order of t; of equal t, of the triangles.
    /// Nothing of engines that have no such rule: `trace` refuses to ask them.
    fn crossings(&self, ray: &RayOf<Self::Scalar>) -> Vec<Crossing>;
}
