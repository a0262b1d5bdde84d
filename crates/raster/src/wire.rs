//! Edges drawn over a picture: document E, with the hidden parts left out.

use intertri::Hit;

use crate::adjacency::Adjacency;
use crate::clip::{Point4, clip_edge};
use crate::vector::{double, sub};
use crate::view::View;
use crate::z_buffer::plane;

/// By which part of its distance an edge may lie behind what its pixel shows and still be drawn.
///
/// A pixel's own facet is only known at its centre, and an edge passes by there at up to half a pixel;
/// on a curved surface the next facet's plane may then lie a little before it.
const SLACK: f64 = 1.0 / 500.0;

/// Which pixels edges of a mesh pass through where they are not hidden by what the view shows of it.
///
/// `edges` are pairs of indices into [`Adjacency::points`]: all of [`Adjacency::edges`], or a
/// [`silhouette`](crate::silhouette()) for a light at the eye. An edge is hidden where the plane of the triangle that
/// its pixel shows is nearer than the edge, there where the edge passes, by more than a five hundredth of the distance.
/// An edge with a NaN or an infinity is not drawn.
///
/// # Panics
/// If `hits` has not one entry a pixel, or an edge names a point that is not there.
pub fn wire(
    view: &View,
    hits: &[Hit],
    adjacency: &Adjacency,
    edges: impl IntoIterator<Item = [u32; 2]>,
) -> Vec<bool> {
    let (width, height) = (view.width() as usize, view.height() as usize);
    assert_eq!(hits.len(), width * height, "one hit a pixel");
    let directions = view.pixel_directions();
    let mut drawn = vec![false; hits.len()];
    for ends in edges {
        // Cut the edge down to the picture; z = 0 leaves the sides and w > 0.
        let [a, b] = ends.map(|end| {
            let arm = sub(double(adjacency.points()[end as usize]), view.eye());
            Point4 { z: 0.0, ..view.project(arm, 1.0, 0.0) }
        });
        let Some((a, b)) = clip_edge(a, b) else { continue };

        // One step a pixel along it. On the screen q = 1 / w is linear, as x and y are.
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

            // Is what is shown there in front of the edge?
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
