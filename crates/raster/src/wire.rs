//! Draws the visible parts of edges over an image, clipping the edges as in document E.

use intertri::Hit;

use crate::adjacency::Adjacency;
use crate::clip::{Point4, clip_edge};
use crate::vector::{double, sub};
use crate::view::View;
use crate::z_buffer::plane;

/// The greatest distance behind the visible surface at which an edge is still drawn, as a fraction
/// of the edge's distance.
///
/// A pixel's facet is known only at the pixel's centre, but an edge may pass up to half a pixel
/// away from the centre. On a curved surface, the facet's plane may be slightly in front of the
/// edge there.
const SLACK: f64 = 1.0 / 500.0;

/// Returns the pixels through which edges of a mesh pass, except where visible surfaces hide them.
///
/// `edges` are pairs of indices into [`Adjacency::points`]: all of [`Adjacency::edges`], or a
/// [`silhouette`](crate::silhouette()) for a light at the eye. At each pixel, an edge is hidden if
/// the plane of the visible triangle is nearer than the edge by more than one five-hundredth of the
/// distance. Edges with a NaN or infinite coordinate are not drawn.
///
/// # Panics
/// Panics if `hits` does not have one entry per pixel, or if an edge refers to a missing point.
pub fn wire(
    view: &View,
    hits: &[Hit],
    adjacency: &Adjacency,
    edges: impl IntoIterator<Item = [u32; 2]>,
) -> Vec<bool> {
    let (width, height) = (view.width() as usize, view.height() as usize);
    assert_eq!(hits.len(), width * height, "there must be one hit per pixel");
    let directions = view.pixel_directions();
    let mut drawn = vec![false; hits.len()];
    for ends in edges {
        // Clip the edge to the image. With z = 0, only the sides of the image and w > 0 matter.
        let [a, b] = ends.map(|end| {
            let arm = sub(double(adjacency.points()[end as usize]), view.eye());
            Point4 { z: 0.0, ..view.project(arm, 1.0, 0.0) }
        });
        let Some((a, b)) = clip_edge(a, b) else { continue };

        // Take one step per pixel along the edge. On the screen, q = 1 / w is linear, like x and y.
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

            // Check whether the surface that the pixel shows is in front of the edge.
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
