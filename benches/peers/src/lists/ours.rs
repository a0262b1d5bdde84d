//! intertri: all rays in a call, or a call a ray.

use std::ops::Range;
use std::sync::Arc;

use intertri::{Mode, Ray};
use intertri_trace::{Bvh, HitLists};

use super::answer;
use crate::engine::{Answer, Engine, Question, Singles};

/// The batch call.
pub struct Batch<M> {
    bvh: Arc<Bvh>,
    mode: M,
    limit: Option<usize>,
    rays: Vec<Ray>,
    /// By the part that was asked.
    lists: Vec<(usize, HitLists)>,
}

impl<M: Mode> Batch<M> {
    pub fn new(bvh: Arc<Bvh>, mode: M, limit: Option<usize>) -> Self {
        Self { bvh, mode, limit, rays: vec![], lists: vec![] }
    }
}

impl<M: Mode> Engine for Batch<M> {
    fn load(&mut self, rays: &[Ray], _: Question) {
        self.rays = rays.to_vec();
        self.lists.clear();
    }

    fn trace(&mut self, part: Range<usize>) {
        let lists = self.bvh.all_batch(&self.mode, &self.rays[part.clone()], self.limit);
        let lists = lists.expect("memory for the lists");
        self.lists.retain(|(first, old)| *first + old.len() <= part.start || *first >= part.end);
        self.lists.push((part.start, lists));
    }

    fn answers(&self) -> Vec<Answer> {
        let mut answers = vec![Answer::MISS; self.rays.len()];
        for (first, lists) in &self.lists {
            for (list, to) in lists.iter().zip(&mut answers[*first..]) {
                *to = answer(list.len());
            }
        }
        answers
    }
}

/// The call for a single ray.
pub struct Single<M> {
    bvh: Arc<Bvh>,
    mode: M,
    rays: Singles<Ray>,
}

impl<M: Mode> Single<M> {
    pub fn new(bvh: Arc<Bvh>, mode: M) -> Self {
        Self { bvh, mode, rays: Singles::default() }
    }
}

impl<M: Mode> Engine for Single<M> {
    fn load(&mut self, rays: &[Ray], question: Question) {
        self.rays.load(rays, question, |ray| *ray);
    }

    fn trace(&mut self, part: Range<usize>) {
        let Self { bvh, mode, rays } = self;
        rays.trace(part, |ray| answer(bvh.all(mode, ray).len()), |ray| bvh.any(mode, ray));
    }

    fn answers(&self) -> Vec<Answer> {
        self.rays.answers()
    }
}
