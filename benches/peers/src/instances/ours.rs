//! Engines that trace intertri's scenes of instances.

use std::ops::Range;
use std::sync::Arc;

use intertri::Ray64;
use intertri_trace::{SceneHit, SceneSnapshot};

use crate::engine::{Answer, Engine, Question, Singles};

/// Traces with the batch queries.
pub struct Instances {
    scene: SceneSnapshot,
    firsts: Arc<[u32]>,
    rays: Vec<Ray64>,
    any: bool,
    hits: Vec<SceneHit>,
    seen: Vec<bool>,
}

impl Instances {
    pub fn new(scene: SceneSnapshot, firsts: Arc<[u32]>) -> Self {
        Self { scene, firsts, rays: vec![], any: false, hits: vec![], seen: vec![] }
    }
}

impl Engine<Ray64> for Instances {
    fn load(&mut self, rays: &[Ray64], question: Question) {
        (self.rays, self.any) = (rays.to_vec(), question.any);
        self.hits = vec![SceneHit::MISS; rays.len()];
        self.seen = vec![false; rays.len()];
    }

    fn trace(&mut self, part: Range<usize>) {
        let rays = &self.rays[part.clone()];
        if self.any {
            self.scene.any_batch_into(rays, &mut self.seen[part]);
        } else {
            self.scene.closest_batch_into(rays, &mut self.hits[part]);
        }
    }

    fn answers(&self) -> Vec<Answer> {
        if self.any {
            self.seen.iter().map(|&hit| if hit { Answer::ANY } else { Answer::MISS }).collect()
        } else {
            self.hits.iter().map(|hit| named(&self.firsts, hit)).collect()
        }
    }
}

/// Traces one ray per call.
pub struct InstancesSingle {
    scene: SceneSnapshot,
    firsts: Arc<[u32]>,
    rays: Singles<Ray64>,
}

impl InstancesSingle {
    pub fn new(scene: SceneSnapshot, firsts: Arc<[u32]>) -> Self {
        Self { scene, firsts, rays: Singles::default() }
    }
}

impl Engine<Ray64> for InstancesSingle {
    fn load(&mut self, rays: &[Ray64], question: Question) {
        self.rays.load(rays, question, |ray| *ray);
    }

    fn trace(&mut self, part: Range<usize>) {
        let Self { scene, firsts, rays } = self;
        rays.trace(
            part,
            |ray| scene.closest(ray).map_or(Answer::MISS, |hit| named(firsts, &hit)),
            |ray| scene.any(ray),
        );
    }

    fn answers(&self) -> Vec<Answer> {
        self.rays.answers()
    }
}

/// Converts a hit into an answer with the triangle's index in the flattened scene.
fn named(firsts: &[u32], SceneHit { hit, instance, .. }: &SceneHit) -> Answer {
    if hit.is_hit() {
        Answer { triangle: firsts[instance.index()] + hit.triangle, t: hit.t }
    } else {
        Answer::MISS
    }
}
