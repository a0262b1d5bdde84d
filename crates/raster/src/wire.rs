//! Edges drawn over a picture: document E, with the hidden parts left out.

use intertri::Hit;

use crate::adjacency::Adjacency;
use crate::clip::{Point4, clip_edge};
use crate::vector::{double, sub};
use crate::view::View;
use crate::z_buffer::plane;

/// The fraction of its distance by which an edge may lie behind its pixel's surface and still be drawn.
///
/// A pixel's facet is only known at its centre, and an edge passes up to half a pixel away; on a curved
/// surface the next facet's plane may be slightly in front of it there.
const SLACK: f64 = 1.0 / 500.0;

/// The pixels through which edges of a mesh pass, except where the picture's surfaces hide them.
///
/// `edges` are pairs of indices into [`Adjacency::points`]: all of [`Adjacency::edges`], or a
/// [`silhouette`](crate::silhouette()) for a light at the eye. An edge is hidden if, where it passes, the
/// plane of the triangle that its pixel shows is nearer than the edge by more than one five-hundredth of the
/// distance. An edge with a NaN or an infinity is not drawn.
///
/// # Panics
/// Panics if `hits` does not have one entry per pixel, or an edge refers to a missing point.
pub fn wire(
    view: &View,
    hits: &[Hit],
    adjacency: &Adjacency,
    edges: impl IntoIterator<Item = [u32; 2]>,
) -> Vec<bool> {
    let (width, height) = (view.width() as usize, view.height() as usize);
    assert_eq!(hits.len(), width * height, "one hit per pixel");
    let directions = view.pixel_directions();
    let mut drawn = vec![false; hits.len()];
    for ends in edges {
        // Clip the edge to the picture; z = 0 leaves only the sides and w > 0.
        let [a, b] = ends.map(|end| {
            let arm = sub(double(adjacency.points()[end as usize]), view.eye());
            Point4 { z: 0.0, ..view.project(arm, 1.0, 0.0) }
        });
        let Some((a, b)) = clip_edge(a, b) else { continue };

        // One step per pixel along it. On the screen q = 1 / w is linear, as are x and y.
        let ([ax, ay], [bx, by]) = (view.pixel(a), view.pixel(b));
        let (aq, bq) = (1.0 / a.w, 1.0 / b.w);
        let steps = (bx - ax).abs().max((by - ay).abs()).ceil();
        if !(steps.is_finite() && aq.is_finite() && bq.is_finite()) {
            continue;
        }
        for i in 0..=steps as u32 {
            let t = if steps > 0.0 { f64::from(i) / steps } else { 0.0 };
            let (x, y, q) = (ax + t * (bx - ax), ay + t * (by - ay), aq + t * (bq - aq));
            let pixel = (y as usize).min(height - 1) * width + (x as usize).min(width - 1);

            // Is the surface shown there in front of the edge?
            let face = usize::try_from(hits[pixel].triangle).ok();
            let face = face.filter(|&face| face < adjacency.faces().len());
            let plane =
                face.and_then(|face| plane(view, &directions, adjacency.corners(face).map(double)));
            let hidden = plane.is_some_and(|plane| plane.at(x, y) > q * (1.0 + SLACK));
            drawn[pixel] |= !hidden;
        }
    }
    drawn
}
