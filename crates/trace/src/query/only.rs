//! Queries among the triangles that count.

use intertri::{Counts, Hit, RayOf};

use super::batch::{self, Many};
use super::lists::{self, HitLists};
use super::one;
use crate::answers::Answers;
use crate::bvh::Bvh;
use crate::given::{Given, ModeFor};
use crate::memory::OutOfMemory;
use crate::select::{Choice, Select};
use crate::single::Kept;

/// A hierarchy of which some triangles count: what [`Bvh::only`] gives.
#[derive(Clone, Copy, Debug)]
pub struct Only<'a, S: Given = f32> {
    pub(super) bvh: &'a Bvh<S>,
    pub(super) select: &'a Select<'a>,
}

impl<'a, S: Given> Only<'a, S> {
    pub(super) fn new(bvh: &'a Bvh<S>, select: &'a Select<'a>) -> Self {
        Self { bvh, select }
    }

    /// The choice for one ray.
    #[inline(always)]
    pub(super) fn one(&self) -> Choice<'a> {
        self.check(1);
        self.select.of(&self.bvh.tree)
    }

    /// The answer of each ray, on all threads where there are threads.
    pub(super) fn answer<M: ModeFor<S>>(
        &self,
        mode: &M,
        rays: &[RayOf<S>],
        answers: Answers<'_>,
    ) -> Counts {
        self.many(mode, rays, |many| batch::answer(many, answers))
    }

    /// The answer of each ray among all triangles, whatever their masks, on this thread.
    pub(super) fn on_this_thread<M: ModeFor<S>>(
        &self,
        mode: &M,
        rays: &[RayOf<S>],
        answers: Answers<'_>,
    ) -> Counts {
        self.asked(mode, rays, None, |many| batch::part(many, 0..rays.len(), answers))
    }

    /// Rays with the choice for them.
    fn many<M: ModeFor<S>, A>(
        &self,
        mode: &M,
        rays: &[RayOf<S>],
        ask: impl FnOnce(&Many<'_>) -> A,
    ) -> A {
        self.check(rays.len());
        self.asked(mode, rays, self.select.of(&self.bvh.tree), ask)
    }

    /// Rays with a choice.
    pub(super) fn asked<M: ModeFor<S>, A>(
        &self,
        mode: &M,
        rays: &[RayOf<S>],
        choice: Choice<'_>,
        ask: impl FnOnce(&Many<'_>) -> A,
    ) -> A {
        let (bvh, which) = (self.bvh, mode.which());
        let (tree, originals) = (&bvh.tree, &bvh.originals);
        ask(&Many {
            bvh: tree,
            choice,
            count: rays.len(),
            piece: S::PIECE,
            rays: &|range, ask| S::walk(tree, originals, &which, (rays, range), ask),
        })
    }

    #[inline(always)]
    fn check(&self, rays: usize) {
        let lists = self.select.skip.len();
        assert!(lists == 0 || lists == rays, "a list of what to skip for each ray, or none");
    }

    /// [`Bvh::closest`] of the triangles that count.
    pub fn closest<M: ModeFor<S>>(&self, mode: &M, ray: &RayOf<S>) -> Option<Hit> {
        let choice = self.one();
        self.bvh.ask_one(mode, ray, |tree, which, ray| {
            one::closest(tree, &choice, which, ray, &mut Kept::lend(tree))
        })
    }

    /// [`Bvh::any`] of the triangles that count.
    pub fn any<M: ModeFor<S>>(&self, mode: &M, ray: &RayOf<S>) -> bool {
        let choice = self.one();
        self.bvh.ask_one(mode, ray, |tree, which, ray| {
            one::any(tree, &choice, which, ray, &mut Kept::lend(tree))
        })
    }

    /// [`Bvh::all`] of the triangles that count.
    pub fn all<M: ModeFor<S>>(&self, mode: &M, ray: &RayOf<S>) -> Vec<Hit> {
        let choice = self.one();
        self.bvh.ask_one(mode, ray, |tree, which, ray| one::all(tree, (&choice, 0), which, ray))
    }

    /// [`Bvh::closest_batch`] of the triangles that count.
    ///
    /// # Panics
    /// If the slices, or the lists of what rays skip, differ in length.
    pub fn closest_batch<M: ModeFor<S>>(
        &self,
        mode: &M,
        rays: &[RayOf<S>],
        hits: &mut [Hit],
    ) -> Counts {
        self.answer(mode, rays, Answers::Hits(hits))
    }

    /// [`Bvh::triangles_batch`] of the triangles that count.
    ///
    /// # Panics
    /// If the slices, or the lists of what rays skip, differ in length.
    pub fn triangles_batch<M: ModeFor<S>>(
        &self,
        mode: &M,
        rays: &[RayOf<S>],
        triangles: &mut [u32],
    ) -> Counts {
        self.answer(mode, rays, Answers::Triangles(triangles))
    }

    /// [`Bvh::any_batch`] of the triangles that count.
    ///
    /// # Panics
    /// If the slices, or the lists of what rays skip, differ in length.
    pub fn any_batch<M: ModeFor<S>>(
        &self,
        mode: &M,
        rays: &[RayOf<S>],
        any: &mut [bool],
    ) -> Counts {
        self.answer(mode, rays, Answers::Any(any))
    }

    /// [`Bvh::all_batch`] of the triangles that count.
    ///
    /// # Errors
    /// If there is too little memory for what is found.
    ///
    /// # Panics
    /// If there are lists of what rays skip, but not one a ray.
    pub fn all_batch<M: ModeFor<S>>(
        &self,
        mode: &M,
        rays: &[RayOf<S>],
        limit: Option<usize>,
    ) -> Result<HitLists, OutOfMemory> {
        Ok(self.many(mode, rays, |many| lists::lists(many, limit))?)
    }
}
