//! Decides, pixel by pixel, where two shadow masks of the same image are allowed to differ.
//!
//! The point that a pixel shows is known only to be in a small ball ([`Ball`]). A difference is
//! excused if the surface of a shadow volume, a side or a near cap, meets that ball:
//!
//! ```text
//!        * light
//!         \
//!    ------\            The side behind the edge of a blocker bounds the silhouette's shadow.
//!           \ .--.      A near cap belongs to a blocker that touches, or to P's own surface if
//!            (\ P )     that surface is edge-on to the light.
//!      -------`--'----- surface
//! ```
//!
//! A triangle that is edge-on to the light casts a flat, empty volume. Its surface still counts,
//! because rounding decides whether a shadow ray along the triangle hits it. Its cap and its three
//! sides are therefore treated like those of other triangles.

use intertri::Hit;

use crate::ball::Ball;
use crate::differences::Verdict;
use crate::silhouette::Light;
use crate::threads;
use crate::view::View;
use crate::volume::Volume;

/// Compares two shadow masks of the same view, row by row.
///
/// Where the masks differ, the visible point is known only to be in a ball. The ball's radius is
/// the distance on the triangle's plane that [`View::tolerance`] pixels cover, plus 2^-24 of the
/// distance to the light (for a directional light, 2^-24 of the distance to the origin plus twice
/// the length of the vector to the light, because its shadow rays start at rounded points). The
/// difference is excused if a near cap or a side of a volume meets the ball, including those of
/// triangles edge-on to the light, or if the visible triangle's plane is edge-on to the eye within
/// the tolerance. If the reach of the light is 1, the visible triangle's own cap does not count,
/// and neither do its own sides if it is edge-on to the light.
///
/// The radius is rounded up. Whether a cap or a side meets the ball is decided in rational
/// arithmetic, from distances between points, lines, and planes.
///
/// # Panics
/// Panics if a slice does not have one entry per pixel, or if a differing pixel shows a triangle
/// that is not in the volume's mesh.
pub fn shadow_differences(
    view: &View,
    hits: &[Hit],
    volume: &Volume<'_>,
    one: &[bool],
    other: &[bool],
) -> Vec<Verdict> {
    let width = view.width() as usize;
    let pixels = width * view.height() as usize;
    assert!(
        [hits.len(), one.len(), other.len()] == [pixels; 3],
        "slices must have one entry per pixel"
    );
    let mut verdicts = vec![Verdict::Same; pixels];
    threads::parts(&mut verdicts, width, |y, row, (): &mut ()| {
        for (x, verdict) in row.iter_mut().enumerate() {
            let i = y * width + x;
            if one[i] != other[i] {
                *verdict = if excused(view, &hits[i], volume, x as u32, y as u32) {
                    Verdict::Excused
                } else {
                    Verdict::Unexcused
                };
            }
        }
    });
    verdicts
}

/// Returns whether the surface of a volume is so close to the visible point that rounding decides
/// whether the point is lit or dark.
fn excused(view: &View, hit: &Hit, volume: &Volume<'_>, x: u32, y: u32) -> bool {
    // A pixel without a hit counts as lit in both masks.
    if !hit.is_hit() {
        return false;
    }
    let own = hit.triangle as usize;
    let Some(ball) = Ball::new(view, volume, own, x, y) else { return true };
    let (Light::Point { reach, .. } | Light::Directional { reach, .. }) = volume.light();
    let by_itself = reach < 1.0;
    let faces = volume.adjacency().faces().iter().enumerate();
    let mut caps = faces.filter(|&(face, _)| by_itself || face != own);
    let mut flat = caps.clone().filter(|&(face, _)| volume.cap(face).is_none());

    volume.silhouette().iter().any(|side| ball.meets_side(side.ends))
        || caps.any(|(_, &cap)| ball.meets_cap(cap))
        || flat.any(|(_, &[a, b, c])| [[a, b], [b, c], [c, a]].iter().any(|&e| ball.meets_side(e)))
}
