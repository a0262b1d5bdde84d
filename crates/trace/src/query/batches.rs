//! Queries for many rays at once.

use intertri::{Counts, Crossings, Hit, Mode, RayOf};

use super::Query;
use crate::batch::{Answer, CrossingLists, HitLists, HitRecord, RayBatch, lists};
use crate::scalar::BvhScalar;
use crate::selection::ActiveSelection;
use crate::tree::MeshTriangle;
use crate::util::memory::OutOfMemory;
use crate::util::threads;

/// Batch queries: many rays per call, using all threads.
///
/// Most methods return a new `Vec`. An `…_into` variant writes to your slice instead, and most of
/// these variants return the number of intersection tests. Result `i` belongs to `rays[i]`.
///
/// Batches are faster if rays that are adjacent in the slice are also close in space. The fastest
/// batches are images: rays that share an origin or a direction and are stored in rows of any width or
/// in tiles, such as 32×32 pixels in Z-order. The library detects them and traces 1024 rays at a time
/// in a narrow cone or tube. Other coherent rays are traced sixteen at a time. Results do not depend on
/// the order.
///
/// If a `Vec` of results cannot be allocated, the program aborts, as with any `Vec`; the `…_into`
/// variants use your memory instead. Methods that return lists of hits report an error.
///
/// # Panics
/// Panics if the numbers of rays and results differ, or if you set lists of triangles to skip but
/// not one per ray.
impl<S: BvhScalar> Query<'_, S> {
    /// Like [`Query::closest`], but for many rays. A ray without a hit yields [`Hit::MISS`].
    ///
    /// ```
    /// use intertri_trace::Bvh;
    /// use intertri_trace::intertri::{Ray, Triangle};
    /// let bvh = Bvh::new(&[Triangle::new([0.0, 0.0, 5.0], [1.0, 0.0, 5.0], [0.0, 1.0, 5.0])])?;
    /// let rays = [0.25, 2.0].map(|x| Ray::new([x, 0.25, 0.0], [0.0, 0.0, 1.0]));
    /// let hits = bvh.query().closest_batch(&rays);
    /// assert!(hits[0].t == 5.0 && !hits[1].is_hit());
    /// # Ok::<(), intertri_trace::BuildError>(())
    /// ```
    pub fn closest_batch(&self, rays: &[RayOf<S>]) -> Vec<Hit> {
        let mut hits = vec![Hit::MISS; rays.len()];
        self.closest_batch_into(rays, &mut hits);
        hits
    }

    /// Like [`Query::closest_batch`], but writes to a slice of [`Hit`]. Use a slice of
    /// [`Hit32`](intertri::Hit32) instead if f32 is precise enough for t, u, and v; it takes less
    /// memory and time.
    ///
    /// ```
    /// use intertri_trace::Bvh;
    /// use intertri_trace::intertri::{Hit32, Ray, Triangle};
    /// let bvh = Bvh::new(&[Triangle::new([0.0, 0.0, 5.0], [3.0, 0.0, 5.0], [0.0, 3.0, 5.0])])?;
    /// let rays = [1.0, 9.0].map(|x| Ray::new([x, 1.0, 0.0], [0.0, 0.0, 1.0]));
    /// let mut hits = [Hit32::MISS; 2];
    /// bvh.query().closest_batch_into(&rays, &mut hits);
    /// assert_eq!((hits[0].t, hits[0].u, hits[0].v), (5.0, 1.0 / 3.0, 1.0 / 3.0));
    /// assert_eq!(hits[1], Hit32::MISS);
    /// # Ok::<(), intertri_trace::BuildError>(())
    /// ```
    pub fn closest_batch_into<H: HitRecord>(&self, rays: &[RayOf<S>], hits: &mut [H]) -> Counts {
        self.trace_batch(self.mode, rays, hits)
    }

    /// Like [`Query::closest_triangle`], but for many rays. A ray without a hit yields
    /// [`MeshTriangle::MISS`].
    pub fn closest_triangle_batch(&self, rays: &[RayOf<S>]) -> Vec<MeshTriangle> {
        let mut triangles = vec![MeshTriangle::MISS; rays.len()];
        self.closest_triangle_batch_into(rays, &mut triangles);
        triangles
    }

    /// Like [`Query::closest_triangle_batch`], but writes the triangles to a slice.
    pub fn closest_triangle_batch_into(
        &self,
        rays: &[RayOf<S>],
        triangles: &mut [MeshTriangle],
    ) -> Counts {
        self.trace_batch(self.mode, rays, triangles)
    }

    /// Like [`Query::any`], but for many rays.
    ///
    /// This is fastest if neighbouring rays share their origin, or if all rays end at one point (up
    /// to rounding), at t = 1 or `t_max`, and do not extend beyond it. For shadows, use
    /// [`Query::visible_batch`], because a ray that starts on a surface may hit that surface after
    /// its origin is rounded.
    pub fn any_batch(&self, rays: &[RayOf<S>]) -> Vec<bool> {
        let mut any = vec![false; rays.len()];
        self.any_batch_into(rays, &mut any);
        any
    }

    /// Like [`Query::any_batch`], but writes the results to a slice.
    pub fn any_batch_into(&self, rays: &[RayOf<S>], any: &mut [bool]) -> Counts {
        self.trace_batch(self.mode, rays, any)
    }

    /// Like [`Query::all`], but for many rays. Returns the hits in compact arrays. If a limit is
    /// given, only that many hits of each ray are kept, starting with the nearest, and traversal
    /// stops at the last of them.
    ///
    /// # Errors
    /// Returns an error if memory runs out.
    ///
    /// ```
    /// use intertri_trace::Bvh;
    /// use intertri_trace::intertri::{Ray, Triangle};
    /// let at = |z| Triangle::new([0.0, 0.0, z], [1.0, 0.0, z], [0.0, 1.0, z]);
    /// let bvh = Bvh::new(&[at(5.0), at(7.0), at(3.0)])?;
    /// let rays = [0.2, 9.0, 0.3].map(|x| Ray::new([x, 0.2, 0.0], [0.0, 0.0, 1.0]));
    /// let lists = bvh.query().all_batch(&rays, Some(2))?;
    /// assert_eq!(lists.offsets, [0, 2, 2, 4]);
    /// assert!(lists.of(2).iter().map(|hit| hit.triangle).eq([2, 0]));
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn all_batch(
        &self,
        rays: &[RayOf<S>],
        limit: Option<usize>,
    ) -> Result<HitLists, OutOfMemory> {
        self.with_batch(self.mode, rays, |batch| Ok(lists(batch, limit)?))
    }

    /// Like [`Query::crossings`], but for many rays. Returns the crossings in compact arrays. If a
    /// limit is given, only that many crossings of each ray are kept, starting with the nearest.
    ///
    /// # Errors
    /// Returns an error if memory runs out.
    pub fn crossings_batch(
        &self,
        rays: &[RayOf<S>],
        limit: Option<usize>,
    ) -> Result<CrossingLists, OutOfMemory> {
        self.with_batch(self.crossing_mode(), rays, |batch| Ok(lists(batch, limit)?))
    }

    /// Returns how many times each ray crosses the mesh.
    pub fn count_crossings_batch(&self, rays: &[RayOf<S>]) -> Vec<Crossings> {
        let mut crossings = vec![Crossings::default(); rays.len()];
        self.count_crossings_batch_into(rays, &mut crossings);
        crossings
    }

    /// Like [`Query::count_crossings_batch`], but writes the results to a slice.
    pub fn count_crossings_batch_into(&self, rays: &[RayOf<S>], crossings: &mut [Crossings]) {
        crossings.fill(Crossings::default());
        self.trace_batch(self.crossing_mode(), rays, crossings);
    }

    fn trace_batch<A: Answer>(&self, mode: Mode, rays: &[RayOf<S>], answers: &mut [A]) -> Counts {
        self.with_batch(mode, rays, |batch| batch.trace(answers))
    }

    /// Passes the rays to `trace` as a batch, on this thread only if the query is set to do so.
    fn with_batch<A>(
        &self,
        mode: Mode,
        rays: &[RayOf<S>],
        trace: impl FnOnce(&RayBatch<'_, S>) -> A,
    ) -> A {
        let lists = self.selection.skip.len();
        // Require one list per ray; otherwise, a ray would use the skip list of another.
        let fits = lists == 0 || lists == rays.len();
        assert!(fits, "pass one list of triangles to skip per ray, or none");
        self.in_threads(|| trace(&self.batch(self.active, mode, rays)))
    }

    /// Traces rays with a given selection of triangles instead of the query's own.
    pub(super) fn with_selection<A: Answer>(
        &self,
        selection: ActiveSelection<'_>,
        mode: Mode,
        rays: &[RayOf<S>],
        answers: &mut [A],
    ) {
        self.in_threads(|| self.batch(selection, mode, rays).trace(answers));
    }

    fn batch<'b>(
        &'b self,
        selection: ActiveSelection<'b>,
        mode: Mode,
        rays: &'b [RayOf<S>],
    ) -> RayBatch<'b, S> {
        let (tree, originals) = (&self.bvh.tree, &self.bvh.originals);
        RayBatch { tree, originals, mode, selection, rays }
    }

    fn in_threads<A>(&self, work: impl FnOnce() -> A) -> A {
        if self.on_this_thread { threads::on_this_thread(work) } else { work() }
    }
}
