//! Decides, pixel by pixel and without rounding, where two images of the same scene are allowed to
//! differ.
//!
//! A traced ray does not pass exactly through the centre of its pixel: the tracer rounds directions
//! to f32, and this crate snaps corners to fractions of a pixel. Together, these roundings shift
//! the image by at most `r`, the [`View::tolerance`] of about 1e-4 pixels. A difference is excused
//! only if a shift of the pixel's centre by at most `r` could explain it:
//!
//! ```text
//!      .-----.            An edge of one of the two facets passes within r of the centre, or
//!    /    ___/____        their depths tie somewhere within r, or
//!   |  . /    |  edge     one of their planes is edge-on somewhere within r.
//!    \  /    /
//!      '-----'  r
//! ```

use intertri::{Hit, Triangle, TriangleOf};

use crate::disc::Disc;
use crate::threads;
use crate::vector::{cross, dot, double, length, sub};
use crate::view::View;

/// The verdict on one pixel of two images.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Verdict {
    /// Both images agree.
    Same,
    /// The images differ, but rounding explains the difference.
    Excused,
    /// The images differ, and one of them is wrong.
    Unexcused,
}

/// Compares the triangle and the depth that each pixel shows in two images of the same triangles
/// with the same view, row by row.
///
/// A different triangle is excused if an edge of either comes within [`View::tolerance`] of the
/// centre of the pixel, or if, at some point within that distance, the depths of their planes are
/// equal or one of the planes is edge-on to the eye. If both images show the same triangle, its
/// depth must also agree: each `t`, a distance from the eye, must occur on the triangle's plane
/// within the tolerance, up to a relative error of 2^-22 for the length of a ray's direction. No
/// other difference in depth is excused.
///
/// All decisions are made in rational arithmetic, on the exact values of the view and the
/// triangles. Only depth comparisons allow for the engines' f64 rounding, about 2^-48 of the
/// products involved (`docs/raster.md`).
///
/// # Panics
/// Panics if a slice does not have one entry per pixel.
pub fn differences(
    view: &View,
    triangles: &[Triangle],
    one: &[Hit],
    other: &[Hit],
) -> Vec<Verdict> {
    let width = view.width() as usize;
    let pixels = width * view.height() as usize;
    assert!(one.len() == pixels && other.len() == pixels, "each image must have one hit per pixel");
    let mut verdicts = vec![Verdict::Same; pixels];
    threads::parts(&mut verdicts, width, |y, row, (): &mut ()| {
        for (x, verdict) in row.iter_mut().enumerate() {
            let pair = [one, other].map(|hits| &hits[y * width + x]);
            let seen = pair.map(|hit| triangles.get(usize::try_from(hit.triangle).ok()?));
            let (x, y) = (x as u32, y as u32);
            *verdict = if pair[0].triangle == pair[1].triangle {
                let at_depth = |t| seen[0].is_none_or(|seen| may_be_at(view, seen, t, x, y));
                if pair.iter().all(|hit| at_depth(hit.t)) {
                    Verdict::Same
                } else {
                    Verdict::Unexcused
                }
            } else if Disc::new(view, x, y).excuses(seen) {
                Verdict::Excused
            } else {
                Verdict::Unexcused
            };
        }
    });
    verdicts
}

/// Returns whether a triangle can be visible at the distance `t` in a pixel.
fn may_be_at(view: &View, triangle: &Triangle, t: f64, x: u32, y: u32) -> bool {
    clearly_at(view, triangle, t, x, y)
        .unwrap_or_else(|| Disc::new(view, x, y).may_be_at(triangle, t))
}

/// Decides clear cases quickly in f64: a difference below half the allowance or above twice the
/// allowance. The rounding error of this test is far smaller than the allowance.
fn clearly_at(view: &View, TriangleOf(corners): &Triangle, t: f64, x: u32, y: u32) -> Option<bool> {
    let [c1, c2, c3] = corners.map(double);
    let [p, q, arm] = [sub(c2, c1), sub(c3, c1), sub(c1, view.eye())];
    let normal = cross(p, q);
    let offset = dot(normal, arm);
    let (directions, (d, far)) = (view.pixel_directions(), view.through(x, y));
    let depth = dot(normal, d) / offset;
    let slope = (dot(normal, directions.dx) / offset).hypot(dot(normal, directions.dy) / offset);

    let products = length(p) * length(q) * (far + depth.abs() * length(arm));
    let rounding = 2f64.powi(-48) * products / offset.abs();
    let allowed = view.tolerance() * slope + 2f64.powi(-22) * depth;
    let off = (depth - far / t).abs();
    let certain = rounding.is_finite() && rounding <= 2f64.powi(-28) * depth;
    if !certain {
        None
    } else if off <= 0.5 * allowed {
        Some(true)
    } else {
        (off > 2.0 * allowed).then_some(false)
    }
}
