//! The modes of intertri, through its hierarchy.

use std::ops::Range;
use std::sync::Arc;

use intertri::internal::{Resolver, Test};
use intertri::{Hit, Mode, Ray};
use intertri_trace::Bvh;

use crate::engine::{Answer, Engine, Question, Singles};

/// The batch calls.
pub struct Batch<M> {
    bvh: Arc<Bvh>,
    mode: M,
    rays: Vec<Ray>,
    any: bool,
    hits: Vec<Hit>,
    seen: Vec<bool>,
}

impl<M: Mode> Batch<M> {
    pub fn new(bvh: Arc<Bvh>, mode: M) -> Self {
        Self { bvh, mode, rays: vec![], any: false, hits: vec![], seen: vec![] }
    }
}

impl<M: Mode> Engine for Batch<M> {
    fn load(&mut self, rays: &[Ray], question: Question) {
        self.rays = rays.to_vec();
        self.any = question.any;
        self.hits = vec![Hit::MISS; rays.len()];
        self.seen = vec![false; rays.len()];
    }

    fn trace(&mut self, part: Range<usize>) {
        if self.any {
            self.bvh.any_batch(&self.mode, &self.rays[part.clone()], &mut self.seen[part]);
        } else {
            self.bvh.closest_batch(&self.mode, &self.rays[part.clone()], &mut self.hits[part]);
        }
    }

    fn answers(&self) -> Vec<Answer> {
        if self.any {
            self.seen.iter().map(|&hit| if hit { Answer::ANY } else { Answer::MISS }).collect()
        } else {
            self.hits.iter().map(answer).collect()
        }
    }

    fn exact(&self) -> bool {
        as_document(&self.mode)
    }
}

/// The batch call that tells the triangle alone; of any hit, the batch call.
pub struct Triangles<M> {
    batch: Batch<M>,
    triangles: Vec<u32>,
}

impl<M: Mode> Triangles<M> {
    pub fn new(bvh: Arc<Bvh>, mode: M) -> Self {
        Self { batch: Batch::new(bvh, mode), triangles: vec![] }
    }
}

impl<M: Mode> Engine for Triangles<M> {
    fn load(&mut self, rays: &[Ray], question: Question) {
        self.batch.load(rays, question);
        self.triangles = vec![u32::MAX; rays.len()];
    }

    fn trace(&mut self, part: Range<usize>) {
        let Batch { bvh, mode, rays, any, .. } = &self.batch;
        if *any {
            self.batch.trace(part);
        } else {
            bvh.triangles_batch(mode, &rays[part.clone()], &mut self.triangles[part]);
        }
    }

    fn answers(&self) -> Vec<Answer> {
        if self.batch.any {
            self.batch.answers()
        } else {
            let answer = |&triangle| Answer { triangle, t: f64::NAN };
            self.triangles.iter().map(answer).collect()
        }
    }
}

/// The calls for a single ray.
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
        rays.trace(
            part,
            |ray| bvh.closest(mode, ray).map_or(Answer::MISS, |hit| answer(&hit)),
            |ray| bvh.any(mode, ray),
        );
    }

    fn answers(&self) -> Vec<Answer> {
        self.rays.answers()
    }

    fn exact(&self) -> bool {
        as_document(&self.mode)
    }
}

/// Whether every bit of t is that of document A.
fn as_document<M: Mode>(mode: &M) -> bool {
    matches!(mode.test().resolver(), Resolver::Document(_))
}

fn answer(hit: &Hit) -> Answer {
    Answer { triangle: hit.triangle, t: hit.t }
}
