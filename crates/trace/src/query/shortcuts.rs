//! Shortcuts for queries that use the default mode and consider all triangles.

use intertri::{Crossing, Hit, Mode, RayOf};

use super::Verb;
use crate::batch::{CrossingLists, HitLists};
use crate::bvh::Bvh;
use crate::scalar::BvhScalar;
use crate::selection::Selection;
use crate::util::memory::OutOfMemory;
use crate::walk::one_ray;
use crate::walk::single::TraversalScratch;

/// Shortcuts for queries in exact mode ([`Mode::exact`](intertri::Mode::exact)) over all triangles:
/// `bvh.closest(&ray)` is the same as `bvh.query().closest(&ray)`. See [`Query`](crate::Query) for
/// a description of the methods and for settings.
impl<S: BvhScalar> Bvh<S> {
    /// Returns the closest hit; see [`Query::closest`](crate::Query::closest).
    #[inline]
    pub fn closest(&self, ray: &RayOf<S>) -> Option<Hit> {
        self.trace_alone(ray, one_ray::closest)
    }

    /// Returns whether the ray hits anything; see [`Query::any`](crate::Query::any).
    #[inline]
    pub fn any(&self, ray: &RayOf<S>) -> bool {
        self.trace_alone(ray, one_ray::any)
    }

    /// Returns all hits; see [`Query::all`](crate::Query::all).
    pub fn all(&self, ray: &RayOf<S>) -> Vec<Hit> {
        self.query().all(ray)
    }

    /// Returns the ray's crossings with the mesh; see
    /// [`Query::crossings`](crate::Query::crossings).
    pub fn crossings(&self, ray: &RayOf<S>) -> Vec<Crossing> {
        self.query().crossings(ray)
    }

    /// Returns the next crossing of a ray; see
    /// [`Query::next_crossing`](crate::Query::next_crossing).
    pub fn next_crossing(&self, ray: &RayOf<S>) -> Option<Crossing> {
        self.query().next_crossing(ray)
    }

    /// Returns whether two points see each other; see [`Query::visible`](crate::Query::visible).
    pub fn visible(&self, a: [S; 3], b: [S; 3]) -> bool {
        self.query().visible(a, b)
    }

    /// Returns the closest hit of each ray; see
    /// [`Query::closest_batch`](crate::Query::closest_batch).
    pub fn closest_batch(&self, rays: &[RayOf<S>]) -> Vec<Hit> {
        self.query().closest_batch(rays)
    }

    /// Returns whether each ray hits anything; see [`Query::any_batch`](crate::Query::any_batch).
    pub fn any_batch(&self, rays: &[RayOf<S>]) -> Vec<bool> {
        self.query().any_batch(rays)
    }

    /// Returns all hits of each ray; see [`Query::all_batch`](crate::Query::all_batch).
    ///
    /// # Errors
    /// Returns an error if memory runs out.
    pub fn all_batch(&self, rays: &[RayOf<S>]) -> Result<HitLists, OutOfMemory> {
        self.query().all_batch(rays, None)
    }

    /// Returns the crossings of each ray; see
    /// [`Query::crossings_batch`](crate::Query::crossings_batch).
    ///
    /// # Errors
    /// Returns an error if memory runs out.
    pub fn crossings_batch(&self, rays: &[RayOf<S>]) -> Result<CrossingLists, OutOfMemory> {
        self.query().crossings_batch(rays, None)
    }

    /// Returns whether the two ends of each segment see each other; see
    /// [`Query::visible_batch`](crate::Query::visible_batch).
    pub fn visible_batch(&self, segments: &[[[S; 3]; 2]]) -> Vec<bool> {
        self.query().visible_batch(segments)
    }

    /// Traces one ray without creating a [`Query`](crate::Query), which would take a twentieth of
    /// the total time.
    #[inline(always)]
    fn trace_alone<A>(&self, ray: &RayOf<S>, verb: Verb<A>) -> A {
        let selection = Selection::ALL.active(&self.tree);
        // The thread keeps its scratch memory between calls, so a shortcut allocates nothing.
        let scratch = &mut TraversalScratch::lend(&self.tree);
        self.trace_ray(Mode::exact(), &selection, ray, scratch, verb)
    }
}
