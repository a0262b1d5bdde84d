//! Lists hits with intertri, either with batch calls or with one call per ray.

use std::ops::Range;
use std::sync::Arc;

use intertri::{Mode, Ray};
use intertri_trace::{Bvh, HitLists};

use super::answer;
use crate::engine::{Answer, Engine, Question, Singles};

/// Lists hits with the batch call.
pub struct Batch {
    bvh: Arc<Bvh>,
    mode: Mode,
    limit: Option<usize>,
    rays: Vec<Ray>,
    /// For each part of the rays that was traced, the index of its first ray and its hit lists.
    lists: Vec<(usize, HitLists)>,
}

impl Batch {
    pub fn new(bvh: Arc<Bvh>, mode: Mode, limit: Option<usize>) -> Self {
        Self { bvh, mode, limit, rays: vec![], lists: vec![] }
    }
}

impl Engine for Batch {
    fn load(&mut self, rays: &[Ray], _: Question) {
        self.rays = rays.to_vec();
        self.lists.clear();
    }

    fn trace(&mut self, part: Range<usize>) {
        let query = self.bvh.query().mode(self.mode);
        let lists = query.all_batch(&self.rays[part.clone()], self.limit);
        let lists = lists.expect("not enough memory for the lists");
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

/// Lists hits with the single-ray call.
pub struct Single {
    bvh: Arc<Bvh>,
    mode: Mode,
    rays: Singles<Ray>,
}

impl Single {
    pub fn new(bvh: Arc<Bvh>, mode: Mode) -> Self {
        Self { bvh, mode, rays: Singles::default() }
    }
}

impl Engine for Single {
    fn load(&mut self, rays: &[Ray], question: Question) {
        self.rays.load(rays, question, |ray| *ray);
    }

    fn trace(&mut self, part: Range<usize>) {
        let Self { bvh, mode, rays } = self;
        let query = || bvh.query().mode(*mode);
        rays.trace(part, |ray| answer(query().all(ray).len()), |ray| query().any(ray));
    }

    fn answers(&self) -> Vec<Answer> {
        self.rays.answers()
    }
}
