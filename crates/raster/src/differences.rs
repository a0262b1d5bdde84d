//! Where two pictures of the same scene may differ, decided pixel by pixel.
//!
//! A traced ray and the centre of its pixel are not the same line: the tracer rounds directions to
//! f32, and here corners are snapped to parts of a pixel. Together they shift what is seen by at most
//! [`View::tolerance`], `r`, a distance in the picture of about 1e-4 pixels. Whatever a pixel shows
//! for some point within `r` of its centre excuses a difference, and nothing else does:
//!
//! ```text
//!      .-----.            an edge of one of the two facets passes within r of the centre, or
//!    /    ___/____        somewhere within r one facet is in front, and elsewhere the other: their
//!   |  . /    |  edge     depths tie, or a plane is seen so edge-on that its depth is unbounded
//!    \  /    /
//!      '-----'  r
//! ```

use intertri::{Hit, Triangle};

use crate::clip::{Point4, clip_edge};
use crate::threads;
use crate::vector::{cross, dot, double, length, sub};
use crate::view::View;

/// What one pixel of two pictures is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Verdict {
    /// Both show the same.
    Same,
    /// They differ, and the rule explains why they may.
    Excused,
    /// They differ, and one of them is wrong.
    Unexcused,
}

/// Compares which triangle each pixel shows, and at which depth, in two pictures of the same triangles
/// by the same view, row by row.
///
/// Another triangle is excused where the centre of the pixel is within [`View::tolerance`] of an edge of
/// either triangle (as far as that edge is in the picture), or where the two planes, or one plane and
/// the horizon, tie in depth at some point within that distance. The same triangle must be at the same
/// depth: both `t`, the distances from the eye, are what its plane has within that distance, up to
/// 2^-22 of them for the length of a ray's direction; nothing excuses another.
///
/// # Panics
/// If a slice is not as long as the view has pixels.
pub fn differences(
    view: &View,
    triangles: &[Triangle],
    one: &[Hit],
    other: &[Hit],
) -> Vec<Verdict> {
    let width = view.width() as usize;
    let pixels = width * view.height() as usize;
    assert!(one.len() == pixels && other.len() == pixels, "one hit a pixel");
    let mut verdicts = vec![Verdict::Same; pixels];
    threads::parts(&mut verdicts, width, |y, row, (): &mut ()| {
        for (x, verdict) in row.iter_mut().enumerate() {
            let pair = [one, other].map(|hits| &hits[y * width + x]);
            let seen = pair.map(|hit| triangles.get(usize::try_from(hit.triangle).ok()?));
            let (x, y) = (x as u32, y as u32);
            *verdict = if pair[0].triangle == pair[1].triangle {
                let agree = pair.iter().all(|hit| at_depth(view, seen[0], hit.t, x, y));
                if agree { Verdict::Same } else { Verdict::Unexcused }
            } else if excused(view, seen, x, y) {
                Verdict::Excused
            } else {
                Verdict::Unexcused
            };
        }
    });
    verdicts
}

/// Whether a pixel may show either of two triangles, or nothing instead of one of them.
fn excused(view: &View, seen: [Option<&Triangle>; 2], x: u32, y: u32) -> bool {
    let centre = [x, y].map(|c| f64::from(c) + 0.5);
    let near_edge = |triangle: &Triangle| edge_distance(view, triangle, centre) <= view.tolerance();
    if seen.iter().flatten().any(|triangle| near_edge(triangle)) {
        return true;
    }

    // q over the disc: what is not a hit has q = 0, as if it were at infinity.
    let [one, other] =
        seen.map(|triangle| triangle.map_or((0.0, 0.0), |t| depths(view, t, centre)));
    one.0 <= other.1 && other.0 <= one.1
}

/// Whether a triangle, if there is one, can be seen at the distance `t` in a pixel.
fn at_depth(view: &View, triangle: Option<&Triangle>, t: f64, x: u32, y: u32) -> bool {
    let Some(triangle) = triangle else { return true };
    let (lo, hi) = depths(view, triangle, [x, y].map(|c| f64::from(c) + 0.5));
    let q = view.through(x, y).1 / t;
    let slack = q * 2f64.powi(-22);
    lo <= q + slack && q - slack <= hi
}

/// The distance in pixels from a place of the picture to the nearest edge of a triangle, as far as
/// its edges are in the picture; infinity where none is.
fn edge_distance(view: &View, Triangle(corners): &Triangle, place: [f64; 2]) -> f64 {
    let [a, b, c] = corners.map(|corner| {
        // z = 0 leaves only the four sides of the picture and w > 0.
        Point4 { z: 0.0, ..view.project(sub(double(corner), view.eye()), 1.0, 0.0) }
    });
    let edges = [(a, b), (b, c), (c, a)].into_iter().filter_map(|(a, b)| clip_edge(a, b));
    edges
        .map(|(a, b)| segment_distance(view.pixel(a), view.pixel(b), place))
        .fold(f64::INFINITY, f64::min)
}

/// The distance from p to the segment from a to b.
fn segment_distance(a: [f64; 2], b: [f64; 2], p: [f64; 2]) -> f64 {
    let (along, to) = ([b[0] - a[0], b[1] - a[1]], [p[0] - a[0], p[1] - a[1]]);
    let square = along[0] * along[0] + along[1] * along[1];
    let t = if square > 0.0 { (to[0] * along[0] + to[1] * along[1]) / square } else { 0.0 };
    let t = t.clamp(0.0, 1.0);
    (to[0] - t * along[0]).hypot(to[1] - t * along[1])
}

/// The least and the most of q, the inverse of the view depth, of a triangle's plane within the
/// tolerance of a place; nothing is known of a plane without a normal or through the eye.
fn depths(view: &View, Triangle(corners): &Triangle, [x, y]: [f64; 2]) -> (f64, f64) {
    let [c1, c2, c3] = corners.map(double);
    let normal = cross(sub(c2, c1), sub(c3, c1));
    let sight = view.sight();
    let offset = dot(normal, sub(c1, view.eye()));
    let q = dot(normal, view.direction(x, y)) / offset;
    let slope = (dot(normal, sight.dx) / offset).hypot(dot(normal, sight.dy) / offset);

    // f64 itself rounds by some 2^-50 of |n||d| / (n & a).
    let rounding = length(normal) * view.longest() / offset.abs() * 2f64.powi(-49);
    let slack = view.tolerance() * slope + rounding;
    if slack.is_finite() && q.is_finite() {
        (q - slack, q + slack)
    } else {
        (f64::NEG_INFINITY, f64::INFINITY)
    }
}
