//! Times the scalar f64 reference, with which all other times are compared.

use std::time::Instant;

use intertri_reference as reference;

use super::closest::Seconds;
use crate::test_batch::{ClosestHit, TestBatch};

/// Finds the closest hits of batches with a plain loop over the scalar reference. Returns the time
/// in seconds.
pub fn reference_closest(batches: &[TestBatch], nearest: &mut Vec<ClosestHit>) -> Seconds {
    let scenes: Vec<_> = batches
        .iter()
        .map(|batch| reference::Scene::from_triangles(batch.triangles.iter().map(|t| t.0)))
        .collect();
    nearest.clear();
    nearest.reserve(batches.iter().map(|batch| batch.rays.len()).sum());
    let start = Instant::now();
    for (scene, batch) in scenes.iter().zip(batches) {
        for ray in &batch.rays {
            let line = reference::Ray::new(ray.origin, ray.dir);
            let closest = scene.closest(&line, 0.0, f64::INFINITY);
            nearest.push(
                closest.map_or(ClosestHit::MISS, |(k, t)| ClosestHit { t, triangle: k as u32 }),
            );
        }
    }
    start.elapsed().as_secs_f64()
}
