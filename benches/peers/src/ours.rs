//! The modes of intertri, through its hierarchy.

use std::ops::Range;
use std::sync::Arc;

use intertri::internal::Resolver;
use intertri::{Hit, Ray, RayOf};
use intertri_trace::{Bvh, Given, Intersector, ModeFor};

use crate::engine::{Answer, Engine, Question, Singles};

/// The batch calls.
pub struct Batch<M, S: Given = f32> {
    bvh: Arc<Bvh<S>>,
    mode: M,
    rays: Vec<RayOf<S>>,
    any: bool,
    hits: Vec<Hit>,
    seen: Vec<bool>,
}

impl<M: ModeFor<S>, S: Given> Batch<M, S> {
    pub fn new(bvh: Arc<Bvh<S>>, mode: M) -> Self {
        Self { bvh, mode, rays: vec![], any: false, hits: vec![], seen: vec![] }
    }
}

impl<M: ModeFor<S>, S: Given> Engine<RayOf<S>> for Batch<M, S> {
    fn load(&mut self, rays: &[RayOf<S>], question: Question) {
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
pub struct Triangles<M, S: Given = f32> {
    batch: Batch<M, S>,
    triangles: Vec<u32>,
}

impl<M: ModeFor<S>, S: Given> Triangles<M, S> {
    pub fn new(bvh: Arc<Bvh<S>>, mode: M) -> Self {
        Self { batch: Batch::new(bvh, mode), triangles: vec![] }
    }
}

impl<M: ModeFor<S>, S: Given> Engine<RayOf<S>> for Triangles<M, S> {
    fn load(&mut self, rays: &[RayOf<S>], question: Question) {
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
pub struct Single<M, S: Given = f32> {
    bvh: Arc<Bvh<S>>,
    mode: M,
    rays: Singles<RayOf<S>>,
}

impl<M: ModeFor<S>, S: Given> Single<M, S> {
    pub fn new(bvh: Arc<Bvh<S>>, mode: M) -> Self {
        Self { bvh, mode, rays: Singles::default() }
    }
}

impl<M: ModeFor<S>, S: Given> Engine<RayOf<S>> for Single<M, S> {
    fn load(&mut self, rays: &[RayOf<S>], question: Question) {
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

/// The calls for one ray after another, by an intersector that each chunk of rays makes.
pub struct Kept<M> {
    single: Single<M>,
    /// Whether the triangle alone is asked for.
    triangle: bool,
}

impl<M: ModeFor<f32>> Kept<M> {
    pub fn new(bvh: Arc<Bvh>, mode: M, triangle: bool) -> Self {
        Self { single: Single::new(bvh, mode), triangle }
    }
}

impl<M: ModeFor<f32>> Engine for Kept<M> {
    fn load(&mut self, rays: &[Ray], question: Question) {
        self.single.load(rays, question);
    }

    fn trace(&mut self, part: Range<usize>) {
        let (Single { bvh, mode, rays }, triangle) = (&mut self.single, self.triangle);
        let (make, any) =
            (|| bvh.intersector(mode), |one: &mut Intersector<'_>, ray: &_| one.any(ray));
        if triangle {
            let of = |triangle| Answer { triangle, t: f64::NAN };
            let closest =
                |one: &mut Intersector<'_>, ray: &_| one.triangle(ray).map_or(Answer::MISS, of);
            rays.trace_with(part, make, closest, any);
        } else {
            let of = |hit| answer(&hit);
            let closest =
                |one: &mut Intersector<'_>, ray: &_| one.closest(ray).map_or(Answer::MISS, of);
            rays.trace_with(part, make, closest, any);
        }
    }

    fn answers(&self) -> Vec<Answer> {
        self.single.answers()
    }

    fn exact(&self) -> bool {
        !self.triangle && self.single.exact()
    }
}

/// Whether every bit of t is that of document A.
fn as_document<S>(mode: &impl ModeFor<S>) -> bool {
    matches!(mode.which().resolver(), Resolver::Document(_))
}

fn answer(hit: &Hit) -> Answer {
    Answer { triangle: hit.triangle, t: hit.t }
}
