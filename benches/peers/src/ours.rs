//! Engines that use intertri's modes, through its hierarchy.

use std::ops::Range;
use std::sync::Arc;

use intertri::{Hit, Hit32, Mode, RayOf};
use intertri_trace::{Bvh, BvhScalar, MeshTriangle, Query};

use crate::engine::{Answer, Engine, Question, Singles};

/// The scalar of a scene: f32 in any mode, or f64 in the `exact` mode.
pub trait PeerScalar: BvhScalar {
    /// Creates a query in a mode.
    fn query(bvh: &Bvh<Self>, mode: Mode) -> Query<'_, Self>;
}

impl PeerScalar for f32 {
    #[inline]
    fn query(bvh: &Bvh, mode: Mode) -> Query<'_> {
        bvh.query().mode(mode)
    }
}

impl PeerScalar for f64 {
    #[inline]
    fn query(bvh: &Bvh<f64>, mode: Mode) -> Query<'_, f64> {
        assert!(mode == Mode::exact().at(mode.level()), "an f64 hierarchy supports only `exact`");
        bvh.query().at(mode.level())
    }
}

/// Traces with the batch calls.
pub struct Batch<S: PeerScalar = f32> {
    bvh: Arc<Bvh<S>>,
    mode: Mode,
    rays: Vec<RayOf<S>>,
    any: bool,
    hits: Vec<Hit>,
    seen: Vec<bool>,
}

impl<S: PeerScalar> Batch<S> {
    pub fn new(bvh: Arc<Bvh<S>>, mode: Mode) -> Self {
        Self { bvh, mode, rays: vec![], any: false, hits: vec![], seen: vec![] }
    }
}

impl<S: PeerScalar> Engine<RayOf<S>> for Batch<S> {
    fn load(&mut self, rays: &[RayOf<S>], question: Question) {
        self.rays = rays.to_vec();
        self.any = question.any;
        self.hits = vec![Hit::MISS; rays.len()];
        self.seen = vec![false; rays.len()];
    }

    fn trace(&mut self, part: Range<usize>) {
        let (query, rays) = (S::query(&self.bvh, self.mode), &self.rays[part.clone()]);
        if self.any {
            query.any_batch_into(rays, &mut self.seen[part]);
        } else {
            query.closest_batch_into(rays, &mut self.hits[part]);
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
        as_document(self.mode)
    }
}

/// Traces with the batch call that returns t, u and v in f32. Any-hit queries use the ordinary
/// batch call.
pub struct InF32<S: PeerScalar = f32> {
    batch: Batch<S>,
    hits: Vec<Hit32>,
}

impl<S: PeerScalar> InF32<S> {
    pub fn new(bvh: Arc<Bvh<S>>, mode: Mode) -> Self {
        Self { batch: Batch::new(bvh, mode), hits: vec![] }
    }
}

impl<S: PeerScalar> Engine<RayOf<S>> for InF32<S> {
    fn load(&mut self, rays: &[RayOf<S>], question: Question) {
        self.batch.load(rays, question);
        self.hits = vec![Hit32::MISS; rays.len()];
    }

    fn trace(&mut self, part: Range<usize>) {
        let Batch { bvh, mode, rays, any, .. } = &self.batch;
        if *any {
            self.batch.trace(part);
        } else {
            let query = S::query(bvh, *mode);
            query.closest_batch_into(&rays[part.clone()], &mut self.hits[part]);
        }
    }

    fn answers(&self) -> Vec<Answer> {
        if self.batch.any {
            return self.batch.answers();
        }
        let answer = |hit: &Hit32| Answer { triangle: hit.triangle, t: hit.t.into() };
        self.hits.iter().map(answer).collect()
    }
}

/// Traces with the batch call that returns only the triangle. Any-hit queries use the ordinary
/// batch call.
pub struct Triangles<S: PeerScalar = f32> {
    batch: Batch<S>,
    triangles: Vec<MeshTriangle>,
}

impl<S: PeerScalar> Triangles<S> {
    pub fn new(bvh: Arc<Bvh<S>>, mode: Mode) -> Self {
        Self { batch: Batch::new(bvh, mode), triangles: vec![] }
    }
}

impl<S: PeerScalar> Engine<RayOf<S>> for Triangles<S> {
    fn load(&mut self, rays: &[RayOf<S>], question: Question) {
        self.batch.load(rays, question);
        self.triangles = vec![MeshTriangle::MISS; rays.len()];
    }

    fn trace(&mut self, part: Range<usize>) {
        let Batch { bvh, mode, rays, any, .. } = &self.batch;
        if *any {
            self.batch.trace(part);
        } else {
            let query = S::query(bvh, *mode);
            query.closest_triangle_batch_into(&rays[part.clone()], &mut self.triangles[part]);
        }
    }

    fn answers(&self) -> Vec<Answer> {
        if self.batch.any {
            self.batch.answers()
        } else {
            self.triangles.iter().map(triangle_alone).collect()
        }
    }
}

/// Traces with the single-ray calls.
pub struct Single<S: PeerScalar = f32> {
    bvh: Arc<Bvh<S>>,
    mode: Mode,
    rays: Singles<RayOf<S>>,
}

impl<S: PeerScalar> Single<S> {
    pub fn new(bvh: Arc<Bvh<S>>, mode: Mode) -> Self {
        Self { bvh, mode, rays: Singles::default() }
    }
}

impl<S: PeerScalar> Engine<RayOf<S>> for Single<S> {
    fn load(&mut self, rays: &[RayOf<S>], question: Question) {
        self.rays.load(rays, question, |ray| *ray);
    }

    fn trace(&mut self, part: Range<usize>) {
        let Self { bvh, mode, rays } = self;
        rays.trace(
            part,
            |ray| S::query(bvh, *mode).closest(ray).map_or(Answer::MISS, |hit| answer(&hit)),
            |ray| S::query(bvh, *mode).any(ray),
        );
    }

    fn answers(&self) -> Vec<Answer> {
        self.rays.answers()
    }

    fn exact(&self) -> bool {
        as_document(self.mode)
    }
}

/// What a query for one ray returns.
#[derive(Clone, Copy, PartialEq)]
pub enum Returned {
    /// The hit, with t, u and v in f64.
    Hit,
    /// The hit, with t, u and v in f32.
    Hit32,
    /// Only the triangle.
    Triangle,
}

/// Traces with single-ray calls through a query that is created once per chunk of rays and reused.
pub struct Kept<S: PeerScalar = f32> {
    single: Single<S>,
    returned: Returned,
}

impl<S: PeerScalar> Kept<S> {
    pub fn new(bvh: Arc<Bvh<S>>, mode: Mode, returned: Returned) -> Self {
        Self { single: Single::new(bvh, mode), returned }
    }
}

impl<S: PeerScalar> Engine<RayOf<S>> for Kept<S> {
    fn load(&mut self, rays: &[RayOf<S>], question: Question) {
        self.single.load(rays, question);
    }

    fn trace(&mut self, part: Range<usize>) {
        let Single { bvh, mode, rays } = &mut self.single;
        let make = || S::query(bvh, *mode);
        let any = |one: &mut Query<'_, S>, ray: &_| one.any(ray);
        match self.returned {
            Returned::Triangle => {
                let of = |triangle| triangle_alone(&triangle);
                let closest = |one: &mut Query<'_, S>, ray: &_| {
                    one.closest_triangle(ray).map_or(Answer::MISS, of)
                };
                rays.trace_with(part, make, closest, any);
            }
            Returned::Hit32 => {
                let of = |hit: Hit32| Answer { triangle: hit.triangle, t: hit.t.into() };
                let closest =
                    |one: &mut Query<'_, S>, ray: &_| one.closest32(ray).map_or(Answer::MISS, of);
                rays.trace_with(part, make, closest, any);
            }
            Returned::Hit => {
                let of = |hit| answer(&hit);
                let closest =
                    |one: &mut Query<'_, S>, ray: &_| one.closest(ray).map_or(Answer::MISS, of);
                rays.trace_with(part, make, closest, any);
            }
        }
    }

    fn answers(&self) -> Vec<Answer> {
        self.single.answers()
    }

    fn exact(&self) -> bool {
        self.returned == Returned::Hit && self.single.exact()
    }
}

/// Returns whether t must be bit-identical to that of document A.
fn as_document(mode: Mode) -> bool {
    mode.rule().is_none()
}

fn triangle_alone(triangle: &MeshTriangle) -> Answer {
    Answer { triangle: triangle.triangle, t: f64::NAN }
}

fn answer(hit: &Hit) -> Answer {
    Answer { triangle: hit.triangle, t: hit.t }
}
