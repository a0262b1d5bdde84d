//! Counts the wrong closest hits that each method reports.

use intertri::simd::Level;
use intertri::{Ray, Triangle};
use intertri_reference as reference;

use super::error_counts::ErrorCounts;
use crate::layout::{Form, Layout};
use crate::methods::{METHODS, Method, on_grid, reference_closest};
use crate::oracle;
use crate::test_batch::{ClosestHit, TestBatch};

/// For each method, counts the rays whose reported closest hit is wrong. Returns the number of rays
/// tested.
pub(super) fn closest(batch: &TestBatch, error_counts: &mut [ErrorCounts]) -> u64 {
    let rays = batch.rays.len() as u64;
    let layout = Layout { form: Form::Packets, lanes: 8 };
    let mut nearest = Vec::new();
    let mut ask =
        |method: &Method, batch: &TestBatch, known: &ExpectedAnswers, errors: &mut ErrorCounts| {
            let batches = one(batch);
            if method.closest(Level::best(), batches, layout, &mut nearest).is_some() {
                errors.trials += rays;
                errors.wrong += known.right.wrong(&nearest);
                let differs = |(a, b): &(&ClosestHit, &ClosestHit)| a.triangle != b.triangle;
                let differ = nearest.iter().zip(&known.reference).filter(differs).count();
                errors.not_reference += differ as u64;
            }
        };
    let known = ExpectedAnswers::of(batch);
    for (method, errors) in METHODS.iter().zip(&mut *error_counts) {
        ask(method, batch, &known, errors);
    }
    if let (Some(snapped), Some(errors), Some(fixed)) =
        (on_grid(batch), error_counts.last_mut(), METHODS.last())
    {
        ask(fixed, &snapped, &ExpectedAnswers::of(&snapped), errors);
    }
    rays
}

/// The correct results and the reference's results for a batch, with which every method's results
/// are compared.
struct ExpectedAnswers {
    right: RightAnswers,
    reference: Vec<ClosestHit>,
}

impl ExpectedAnswers {
    fn of(batch: &TestBatch) -> Self {
        let mut reference = Vec::new();
        reference_closest(one(batch), &mut reference);
        Self { right: RightAnswers::of(batch), reference }
    }
}

fn one(batch: &TestBatch) -> &[TestBatch] {
    std::slice::from_ref(batch)
}

/// For each ray, the closest triangle, or several if they have the same t; empty for a miss.
struct RightAnswers(Vec<Vec<u32>>);

impl RightAnswers {
    fn of(batch: &TestBatch) -> Self {
        let of_ray = |ray: &Ray| {
            let hits: Vec<(f64, u32)> = (0..)
                .zip(&batch.triangles)
                .filter(|(_, triangle)| oracle::answer(triangle, ray).is_hit())
                .map(|(k, triangle)| (t(triangle, ray), k))
                .collect();
            // If the ray hits a shared edge, the hits on both triangles have the same t up to
            // rounding.
            let least = hits.iter().fold(f64::INFINITY, |least, hit| least.min(hit.0));
            let is_least = |hit: &&(f64, u32)| hit.0 <= least * (1.0 + 1e-9);
            hits.iter().filter(is_least).map(|hit| hit.1).collect()
        };
        Self(batch.rays.iter().map(of_ray).collect())
    }

    fn wrong(&self, nearest: &[ClosestHit]) -> u64 {
        let is_wrong = |(right, got): &(&Vec<u32>, &ClosestHit)| {
            if right.is_empty() {
                **got != ClosestHit::MISS
            } else {
                !right.contains(&got.triangle)
            }
        };
        self.0.iter().zip(nearest).filter(is_wrong).count() as u64
    }
}

/// Returns t in f64, accurate to about 1e-12.
fn t(triangle: &Triangle, ray: &Ray) -> f64 {
    let scene = reference::Scene::from_triangles([triangle.0]).with_threshold(0.0);
    let mut t = f64::NAN;
    scene.inter_tri(0, &reference::Ray::new(ray.origin, ray.dir), &mut t);
    t
}
