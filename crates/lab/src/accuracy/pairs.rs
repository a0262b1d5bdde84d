//! Counts false hits and false misses on the adversarial mix.

use intertri::simd::Level;
use intertri::{Ray, Triangle};
use intertri_reference as reference;

use super::error_counts::ErrorCounts;
use crate::families::adversarial;
use crate::methods::{METHODS, on_grid};
use crate::oracle::{self, LinePosition};
use crate::rng::Rng;
use crate::test_batch::{Answer, TestBatch};

/// Tests one random pair of the adversarial mix and counts false hits and false misses. Returns the
/// number of pairs, which is 1.
pub(super) fn pairs(rng: &mut Rng, error_counts: &mut [ErrorCounts]) -> u64 {
    let case = adversarial(rng);
    let (triangles, rays) = ([case.triangle], [case.ray]);
    let is_hit = oracle::answer(&case.triangle, &case.ray).is_hit();
    let reference = |triangle: &Triangle, ray: &Ray, threshold| {
        let scene = reference::Scene::from_triangles([triangle.0]).with_threshold(threshold);
        let line = reference::Ray::new(ray.origin, ray.dir);
        scene.hit(0, &line, f64::NEG_INFINITY, f64::INFINITY).is_some()
    };
    let expected = reference(&case.triangle, &case.ray, case.threshold);
    for (method, errors) in METHODS.iter().zip(&mut *error_counts) {
        let mut to = [Answer::default()];
        method.pairs(Level::best(), case.threshold, &triangles, &rays, &mut to);
        errors.trials += 1;
        errors.wrong += u64::from(to[0].hit != is_hit);
        errors.not_reference += u64::from(to[0].hit != expected);
    }
    let batch = TestBatch { rays: rays.to_vec(), triangles: triangles.to_vec() };
    if let (Some(snapped), Some(errors), Some(fixed)) =
        (on_grid(&batch), error_counts.last_mut(), METHODS.last())
    {
        // On an edge or a corner, the tie rule assigns the hit to one of the adjacent triangles, so
        // both answers count as correct.
        let exact = oracle::answer(&snapped.triangles[0], &snapped.rays[0]);
        let tie = matches!(exact.place, LinePosition::Edge(_) | LinePosition::Vertex(_));
        let mut to = [Answer::default()];
        fixed.pairs(Level::best(), 0.0, &snapped.triangles, &snapped.rays, &mut to);
        errors.trials += 1;
        errors.wrong += u64::from(!tie && to[0].hit != exact.is_hit());
        let expected = reference(&snapped.triangles[0], &snapped.rays[0], 0.0);
        errors.not_reference += u64::from(to[0].hit != expected);
    }
    1
}
