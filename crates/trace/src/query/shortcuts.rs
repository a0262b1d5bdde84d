//! The queries in the default mode and among all triangles.

use intertri::{Crossing, Hit, Mode, RayOf};

use super::Verb;
use crate::batch::{CrossingLists, HitLists};
use crate::bvh::Bvh;
use crate::scalar::BvhScalar;
use crate::selection::Selection;
use crate::util::memory::OutOfMemory;
use crate::walk::one_ray;
use crate::walk::single::TraversalScratch;

/// Shortcuts for queries in the mode [`Mode::exact`](intertri::Mode::exact) among all triangles:
/// `bvh.closest(&ray)` is `bvh.query().closest(&ray)`. [`Query`](crate::Query) describes the methods, and the
/// settings.
impl<S: BvhScalar> Bvh<S> {
    /// The closest hit: [`Query::closest`](crate::Query::closest).
    #[inline]
    pub fn closest(&self, ray: &RayOf<S>) -> Option<Hit> {
        self.trace_alone(ray, one_ray::closest)
    }

    /// Whether anything is hit: [`Query::any`](crate::Query::any).
    #[inline]
    pub fn any(&self, ray: &RayOf<S>) -> bool {
        self.trace_alone(ray, one_ray::any)
    }

    /// Every hit: [`Query::all`](crate::Query::all).
    pub fn all(&self, ray: &RayOf<S>) -> Vec<Hit> {
        self.query().all(ray)
    }

    /// Where a ray crosses the mesh: [`Query::crossings`](crate::Query::crossings).
    pub fn crossings(&self, ray: &RayOf<S>) -> Vec<Crossing> {
        self.query().crossings(ray)
    }

    /// The next crossing of a ray: [`Query::next_crossing`](crate::Query::next_crossing).
    pub fn next_crossing(&self, ray: &RayOf<S>) -> Option<Crossing> {
        self.query().next_crossing(ray)
    }

    /// Whether no triangle hides two points from each other: [`Query::visible`](crate::Query::visible).
    pub fn visible(&self, a: [S; 3], b: [S; 3]) -> bool {
        self.query().visible(a, b)
    }

    /// The closest hits of many rays: [`Query::closest_batch`](crate::Query::closest_batch).
    pub fn closest_batch(&self, rays: &[RayOf<S>]) -> Vec<Hit> {
        self.query().closest_batch(rays)
    }

    /// Which of many rays hit anything: [`Query::any_batch`](crate::Query::any_batch).
    pub fn any_batch(&self, rays: &[RayOf<S>]) -> Vec<bool> {
        self.query().any_batch(rays)
    }

    /// Every hit of many rays: [`Query::all_batch`](crate::Query::all_batch).
    ///
    /// # Errors
    /// Fails if there is too little memory for the hits.
    pub fn all_batch(&self, rays: &[RayOf<S>]) -> Result<HitLists, OutOfMemory> {
        self.query().all_batch(rays, None)
    }

    /// The crossings of many rays: [`Query::crossings_batch`](crate::Query::crossings_batch).
    ///
    /// # Errors
    /// Fails if there is too little memory for the crossings.
    pub fn crossings_batch(&self, rays: &[RayOf<S>]) -> Result<CrossingLists, OutOfMemory> {
        self.query().crossings_batch(rays, None)
    }

    /// Which of many segments nothing blocks: [`Query::visible_batch`](crate::Query::visible_batch).
    pub fn visible_batch(&self, segments: &[[[S; 3]; 2]]) -> Vec<bool> {
        self.query().visible_batch(segments)
    }

    /// Traces one ray without creating a query, which takes a twentieth of the time.
    #[inline(always)]
    fn trace_alone<A>(&self, ray: &RayOf<S>, verb: Verb<A>) -> A {
        let selection = Selection::ALL.active(&self.tree);
        // The thread keeps it between calls, so a shortcut costs no allocation.
        let scratch = &mut TraversalScratch::lend(&self.tree);
        self.trace_ray(Mode::exact(), &selection, ray, scratch, verb)
    }
}
