//! Queries over f64 slices with document A's operations, in a plain loop over the triangles.

use alloc::vec::Vec;

use crate::document;
use crate::hit_attributes::of_pair;
use crate::{Hit, Ray64, Threshold, Triangle64, TriangleId};

/// Returns the triangles that a ray hits, in the order of the slice, with their t.
fn found<'a>(
    threshold: Threshold,
    triangles: &'a [Triangle64],
    ray: &'a Ray64,
) -> impl Iterator<Item = (f64, TriangleId)> + 'a {
    (0..).map(TriangleId).zip(triangles).filter_map(move |(id, triangle)| {
        document::hit(ray, triangle, threshold.get()).map(|t| (t, id))
    })
}

/// Returns the closest hit. If several hits have the same t, the lowest index wins.
pub(super) fn closest(threshold: Threshold, triangles: &[Triangle64], ray: &Ray64) -> Option<Hit> {
    // `min_by` returns the first of several equal elements, and the elements are in index order.
    let (_, id) = found(threshold, triangles, ray).min_by(|(a, _), (b, _)| a.total_cmp(b))?;
    Some(of_pair(ray, &triangles[id.0 as usize], id))
}

/// Returns whether the ray hits anything.
pub(super) fn any(threshold: Threshold, triangles: &[Triangle64], ray: &Ray64) -> bool {
    found(threshold, triangles, ray).next().is_some()
}

/// Returns every hit, sorted by t and, for equal t, by index.
pub(super) fn all(threshold: Threshold, triangles: &[Triangle64], ray: &Ray64) -> Vec<Hit> {
    let hits = found(threshold, triangles, ray);
    let mut hits: Vec<Hit> =
        hits.map(|(_, id)| of_pair(ray, &triangles[id.0 as usize], id)).collect();
    // The sort is stable, so hits with equal t stay in index order.
    hits.sort_by(|a, b| a.t.total_cmp(&b.t));
    hits
}
