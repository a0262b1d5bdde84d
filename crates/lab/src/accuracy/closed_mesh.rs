//! Counts the leaks and double hits of rays that leave a closed convex mesh.

use intertri::simd::Level;
use intertri::{Ray, Triangle, TriangleOf};
use intertri_reference as reference;
use robust::Coord3D;

use super::error_counts::ErrorCounts;
use crate::methods::{METHODS, on_grid};
use crate::test_batch::TestBatch;

/// Returns whether a point is inside a closed convex mesh, that is, on the inner side of every
/// triangle.
pub(crate) fn is_within(triangles: &[Triangle], point: [f32; 3]) -> bool {
    let coord = |[x, y, z]: [f32; 3]| Coord3D { x, y, z };
    triangles.iter().all(|TriangleOf(corners)| {
        let [a, b, c] = corners.map(coord);
        robust::orient3d(a, b, c, coord(point)) > 0.0
    })
}

/// Counts the leaks and double hits of rays that leave a mesh at one point. `error_counts` has one
/// entry per method, and optionally one more for [`ON_GRID`]. Returns the number of rays.
pub(crate) fn leaks_and_doubles(batch: &TestBatch, error_counts: &mut [ErrorCounts]) -> u64 {
    let rays = batch.rays.len() as u64;
    let reference = |batch: &TestBatch| -> Vec<u32> {
        let scene = reference::Scene::from_triangles(batch.triangles.iter().map(|t| t.0));
        let hits = |ray: &Ray| {
            let line = reference::Ray::new(ray.origin, ray.dir);
            scene.all(&line, 0.0, f64::INFINITY).len() as u32
        };
        batch.rays.iter().map(hits).collect()
    };
    let add = |errors: &mut ErrorCounts, counts: &[u32], reference: &[u32]| {
        errors.trials += rays;
        errors.leaks += counts.iter().filter(|&&n| n == 0).count() as u64;
        errors.doubles += counts.iter().filter(|&&n| n > 1).count() as u64;
        errors.wrong = errors.leaks + errors.doubles;
        let differ = counts.iter().zip(reference).filter(|(a, b)| a != b).count();
        errors.not_reference += differ as u64;
    };
    let expected = reference(batch);
    for (method, errors) in METHODS.iter().zip(&mut *error_counts) {
        add(errors, &method.counts(Level::best(), batch), &expected);
    }
    if let (Some(snapped), Some(errors), Some(fixed)) =
        (on_grid(batch), error_counts.get_mut(METHODS.len()), METHODS.last())
    {
        add(errors, &fixed.counts(Level::best(), &snapped), &reference(&snapped));
    }
    rays
}
