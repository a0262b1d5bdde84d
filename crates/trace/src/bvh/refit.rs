//! Refits the hierarchy after its triangles have moved.

use intertri::TriangleOf;

use super::Bvh;
use crate::refit::{Refit, RefitError};
use crate::scalar::BvhScalar;

impl<S: BvhScalar> Bvh<S> {
    /// Moves the triangles. Pass the new corners of all triangles in the original order. The tree
    /// keeps its structure; its boxes are recomputed using all threads.
    ///
    /// Query results are bit-for-bit identical to those of a newly built hierarchy. Refitting takes
    /// a small fraction of the time of a build, but the more the triangles move relative to each
    /// other, the slower tracing becomes; [`Refit`] reports how much the tree has degraded.
    /// Triangles may become degenerate or non-finite and recover later.
    ///
    /// # Errors
    /// Returns an error if the number of triangles differs; the hierarchy is then unchanged. Also
    /// returns an error if memory runs out; the hierarchy is then empty.
    ///
    /// ```
    /// use intertri_trace::Bvh;
    /// use intertri_trace::intertri::{Ray, Triangle};
    /// let floor = |y| Triangle::new([-1.0, y, -1.0], [3.0, y, -1.0], [-1.0, y, 3.0]);
    /// let ray = Ray::new([0.0, 9.0, 0.0], [0.0, -1.0, 0.0]);
    /// let mut bvh = Bvh::new(&[floor(0.0), floor(1.0)])?;
    /// let refit = bvh.refit(&[floor(5.0), floor(3.0)])?;
    /// let hit = bvh.closest(&ray);
    /// assert_eq!(hit.map(|hit| (hit.triangle, hit.t)), Some((0, 4.0)));
    /// assert!(refit.ratio() > 0.0 && !refit.is_worn());
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn refit(&mut self, triangles: &[TriangleOf<S>]) -> Result<Refit, RefitError> {
        // Triangles may move to other leaves, so drop the slot table; the next lookup recreates it.
        self.slots.take();
        S::refit(&mut self.tree, &mut self.originals, triangles)
    }
}
