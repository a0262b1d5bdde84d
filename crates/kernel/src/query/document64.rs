//! Slices given in f64, with the document's operations: a plain loop, one triangle at a time.

use alloc::vec::Vec;

use crate::document;
use crate::hit_attributes::of_pair;
use crate::{Hit, Ray64, Threshold, Triangle64, TriangleId};

/// The triangles that a ray hits, in order, with their t.
fn found<'a>(
    threshold: Threshold,
    triangles: &'a [Triangle64],
    ray: &'a Ray64,
) -> impl Iterator<Item = (f64, TriangleId)> + 'a {
    (0..).map(TriangleId).zip(triangles).filter_map(move |(id, triangle)| {
        document::hit(ray, triangle, threshold.get()).map(|t| (t, id))
    })
}

/// The closest hit; if two have the same t, the lowest index.
pub(super) fn closest(threshold: Threshold, triangles: &[Triangle64], ray: &Ray64) -> Option<Hit> {
    // `min_by` returns the first of equal elements, and they are in the order of their indices.
    let (_, id) = found(threshold, triangles, ray).min_by(|(a, _), (b, _)| a.total_cmp(b))?;
    Some(of_pair(ray, &triangles[id.0 as usize], id))
}

/// Whether anything is hit.
pub(super) fn any(threshold: Threshold, triangles: &[Triangle64], ray: &Ray64) -> bool {
    found(threshold, triangles, ray).next().is_some()
}

/// Every hit, by t; if two have the same t, by index.
pub(super) fn all(threshold: Threshold, triangles: &[Triangle64], ray: &Ray64) -> Vec<Hit> {
    let hits = found(threshold, triangles, ray);
    let mut hits: Vec<Hit> =
        hits.map(|(_, id)| of_pair(ray, &triangles[id.0 as usize], id)).collect();
    // A stable sort: hits with equal t stay in the order of their indices.
    hits.sort_by(|a, b| a.t.total_cmp(&b.t));
    hits
}
