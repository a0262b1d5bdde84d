//! Queries among the triangles that count.

use intertri::{Counts, Hit, Mode, Ray};

use super::batch::{self, Asked};
use super::lists::{self, HitLists};
use super::one;
use crate::answers::Answers;
use crate::memory::OutOfMemory;
use crate::select::{Choice, Select};
use crate::tree::Bvh;

/// A hierarchy of which some triangles count: what [`Bvh::only`] gives.
#[derive(Clone, Copy, Debug)]
pub struct Only<'a> {
    pub(super) bvh: &'a Bvh,
    select: &'a Select<'a>,
}

impl<'a> Only<'a> {
    pub(super) fn new(bvh: &'a Bvh, select: &'a Select<'a>) -> Self {
        Self { bvh, select }
    }

    /// The choice for one ray.
    #[inline(always)]
    pub(super) fn one(&self) -> Choice<'a> {
        self.check(1);
        self.select.of(self.bvh)
    }

    /// Rays with the choice for them.
    pub(super) fn many(&self, rays: &'a [Ray]) -> Asked<'a> {
        self.check(rays.len());
        Asked { bvh: self.bvh, choice: self.select.of(self.bvh), rays, on_grid: &[] }
    }

    #[inline(always)]
    fn check(&self, rays: usize) {
        let lists = self.select.skip.len();
        assert!(lists == 0 || lists == rays, "a list of what to skip for each ray, or none");
    }

    /// [`Bvh::closest`] of the triangles that count.
    pub fn closest<M: Mode>(&self, mode: &M, ray: &Ray) -> Option<Hit> {
        one::closest(self.bvh, &self.one(), mode.test().into(), ray)
    }

    /// [`Bvh::any`] of the triangles that count.
    pub fn any<M: Mode>(&self, mode: &M, ray: &Ray) -> bool {
        one::any(self.bvh, &self.one(), mode.test().into(), ray)
    }

    /// [`Bvh::all`] of the triangles that count.
    pub fn all<M: Mode>(&self, mode: &M, ray: &Ray) -> Vec<Hit> {
        one::all(self.bvh, (&self.one(), 0), mode.test().into(), ray)
    }

    /// [`Bvh::closest_batch`] of the triangles that count.
    ///
    /// # Panics
    /// If the slices, or the lists of what rays skip, differ in length.
    pub fn closest_batch<M: Mode>(&self, mode: &M, rays: &[Ray], hits: &mut [Hit]) -> Counts {
        batch::answer(self.many(rays), mode.test().into(), Answers::Hits(hits))
    }

    /// [`Bvh::triangles_batch`] of the triangles that count.
    ///
    /// # Panics
    /// If the slices, or the lists of what rays skip, differ in length.
    pub fn triangles_batch<M: Mode>(
        &self,
        mode: &M,
        rays: &[Ray],
        triangles: &mut [u32],
    ) -> Counts {
        batch::answer(self.many(rays), mode.test().into(), Answers::Triangles(triangles))
    }

    /// [`Bvh::any_batch`] of the triangles that count.
    ///
    /// # Panics
    /// If the slices, or the lists of what rays skip, differ in length.
    pub fn any_batch<M: Mode>(&self, mode: &M, rays: &[Ray], any: &mut [bool]) -> Counts {
        batch::answer(self.many(rays), mode.test().into(), Answers::Any(any))
    }

    /// [`Bvh::all_batch`] of the triangles that count.
    ///
    /// # Errors
    /// If there is too little memory for what is found.
    ///
    /// # Panics
    /// If there are lists of what rays skip, but not one a ray.
    pub fn all_batch<M: Mode>(
        &self,
        mode: &M,
        rays: &[Ray],
        limit: Option<usize>,
    ) -> Result<HitLists, OutOfMemory> {
        Ok(lists::lists(self.many(rays), mode.test().into(), limit)?)
    }
}
