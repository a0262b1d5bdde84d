//! Computes shadows by counting the shadow volumes that contain each visible point.
//!
//! ```text
//!   eye  o-----------(------P----)---->     Along the line of sight, behind the visible point P, the
//!                  enters      leaves       surfaces are counted: +1 where it enters a volume, -1
//!                                           where it leaves one. The sum is minus the number of
//!   eye  o--(-----)---------P---------->    volumes that P is in: 0 is lit.
//! ```
//!
//! Counting behind P ("z-fail") rather than in front of it works wherever the eye is, even in a
//! shadow, because every volume is closed: the far caps at infinity are behind every P. Outlines
//! are drawn with the same exact spans as facets. Their winding numbers are the increments +1 and
//! -1, so a surface that is closed in space is closed at every pixel.
//!
//! **A surface and its own near cap** are in the same plane if the light's reach is 1. Both depths
//! are computed by the same operations from the same corners, so they have the same bits. Ties are
//! resolved so that a face is not in its own shadow: an entering surface counts as behind, and a
//! leaving surface as in front.

use intertri::Hit;
use intertri::simd::{Lanes, Mask, Simd, WithSimd, dispatch};

use crate::batch::{Batch, batches};
use crate::plane::{FacetPlane, range};
use crate::silhouette::Light;
use crate::spans::{BAND, Crossings};
use crate::threads;
use crate::vector::{cross, double, sub};
use crate::view::{PixelDirections, View};
use crate::volume::Volume;
use crate::z_buffer::{centres, plane};

/// Computes which pixels the light reaches, given the hit that each pixel shows (from any engine).
/// A pixel is `false` if a face of the volume's mesh is between the visible point and the light. A
/// pixel that shows nothing is lit.
///
/// The hits must be on the volume's mesh, whose planes determine the depths. If the mesh has no
/// triangle with the index of a hit, the depth is computed from `t`, assuming a direction of unit
/// length.
///
/// # Panics
/// Panics if `hits` does not have one entry per pixel.
pub fn lit(view: &View, hits: &[Hit], volume: &Volume<'_>) -> Vec<bool> {
    let width = view.width() as usize;
    assert_eq!(hits.len(), width * view.height() as usize, "there must be one hit per pixel");
    let directions = view.pixel_directions();
    let seen = depths(view, &directions, hits, volume);

    // Surfaces nearer than the nearest visible point are never counted.
    let nearest = seen.iter().copied().fold(f64::MIN_POSITIVE, f64::max);
    let near = 0.25 / nearest;
    let faces = volume.adjacency().faces().len();
    let batches = batches(view, faces + volume.silhouette().len(), |batch, i| {
        let mesh = Surfaces { view, directions: &directions, volume, near };
        if i < faces { mesh.caps(batch, i) } else { mesh.side(batch, i - faces) }
    });

    let mut lit = vec![true; hits.len()];
    threads::parts(&mut lit, width * BAND as usize, |band, lit, counters: &mut Counters| {
        let first = band * BAND as usize * width;
        let seen = &seen[first..first + lit.len()];
        dispatch(Count { batches: &batches, band, width, seen, counters });
        for (row, (lit, seen)) in lit.chunks_mut(width).zip(seen.chunks(width)).enumerate() {
            let counts = &counters.counts[row * counters.stride..];
            for ((lit, &q), &count) in lit.iter_mut().zip(seen).zip(counts) {
                *lit = count == 0 || q == 0.0;
            }
        }
    });
    lit
}

/// Computes `q`, the inverse of the view depth, for each pixel. A miss has `q = 0`.
fn depths(
    view: &View,
    directions: &PixelDirections,
    hits: &[Hit],
    volume: &Volume<'_>,
) -> Vec<f64> {
    let width = view.width() as usize;
    let mesh = volume.adjacency();
    let mut depths = vec![0.0; hits.len()];
    threads::parts(&mut depths, width, |y, row, last: &mut Option<(u32, Option<FacetPlane>)>| {
        for (x, q) in row.iter_mut().enumerate() {
            let hit = &hits[y * width + x];
            if !hit.is_hit() {
                continue;
            }
            // Neighbouring pixels mostly show the same face.
            if last.is_none_or(|(face, _)| face != hit.triangle) {
                let face = usize::try_from(hit.triangle).ok().filter(|&f| f < mesh.faces().len());
                let plane =
                    face.and_then(|face| plane(view, directions, mesh.corners(face).map(double)));
                *last = Some((hit.triangle, plane));
            }
            *q = match last {
                Some((_, Some(plane))) => plane.at(x as f64 + 0.5, y as f64 + 0.5),
                _ => view.through(x as u32, y as u32).1 / hit.t,
            };
        }
    });
    depths
}

/// The surfaces of a volume, to be drawn in one view.
struct Surfaces<'a> {
    view: &'a View,
    directions: &'a PixelDirections,
    volume: &'a Volume<'a>,
    near: f64,
}

impl Surfaces<'_> {
    /// Adds the near cap of a face and, for a point light, the far cap.
    fn caps(&self, batch: &mut Batch, face: usize) {
        let Self { view, directions, volume, near } = *self;
        let Some(cap) = volume.cap(face) else { return };
        let arm = |point| sub(volume.near(point), view.eye());

        // Compute the depth from the corners in their original order, so that it has the same bits
        // as the surface.
        let outline = cap.map(|point| view.project(arm(point), 1.0, near));
        batch.push(view, outline, 1, || {
            let own = volume.adjacency().faces()[face].map(|point| volume.near(point));
            let edge_on = || FacetPlane::flat(range(own.map(|p| view.depth(sub(p, view.eye())))).0);
            Some(plane(view, directions, own).unwrap_or_else(edge_on))
        });

        if matches!(volume.light(), Light::Point { .. }) {
            let [a, b, c] = cap.map(|point| view.project(volume.far(point), 0.0, near));
            batch.push(view, [a, c, b], 1, || Some(FacetPlane::flat(0.0)));
        }
    }

    /// Adds one side, which traverses a silhouette edge in reverse and extends from the edge to
    /// infinity.
    fn side(&self, batch: &mut Batch, i: usize) {
        let Self { view, directions, volume, near } = *self;
        let side = volume.silhouette()[i];
        let [a, b] = side.ends;
        let close = |point| view.project(sub(volume.near(point), view.eye()), 1.0, near);
        let distant = |point| view.project(volume.far(point), 0.0, near);
        let quad = [close(b), close(a), distant(a), distant(b)];
        let one_far_point = matches!(volume.light(), Light::Directional { .. });
        let corners = quad.into_iter().take(if one_far_point { 3 } else { 4 });

        batch.push(view, corners, side.count as i32, || {
            let [p, q] = [a, b].map(|point| volume.near(point));
            let normal = cross(sub(q, p), volume.far(a));
            let arms = [p, q].map(|p| sub(p, view.eye()));
            // The near points are nearest to the eye, unless the side extends back toward the eye's
            // plane.
            let back = [a, b].map(|point| view.depth(volume.far(point))).into_iter();
            let depths = arms.map(|arm| view.depth(arm)).into_iter();
            let (_, hi) = range(depths.chain(back.filter(|&w| w < 0.0)));
            Some(FacetPlane::new(directions, normal, arms[0], (0.0, hi)))
        });
    }
}

/// The counters of one band, which cannot wrap because there are fewer than 2^30 faces. Each row is
/// padded to fill the last lanes.
#[derive(Default)]
struct Counters {
    stride: usize,
    counts: Vec<i32>,
    seen: Vec<f64>,
    crossings: Crossings,
}

struct Count<'a> {
    batches: &'a [Batch],
    band: usize,
    width: usize,
    seen: &'a [f64],
    counters: &'a mut Counters,
}

impl WithSimd for Count<'_> {
    type Output = ();

    #[inline(always)]
    fn run<S: Simd>(self) {
        let Self { batches, band, width, seen, counters } = self;
        let Counters { stride, counts, seen: depths, crossings } = counters;
        *stride = width + S::F64x8::N;
        counts.clear();
        counts.resize(*stride * BAND as usize, 0);
        depths.clear();
        for row in seen.chunks(width) {
            depths.extend_from_slice(row);
            depths.resize(depths.len() + S::F64x8::N, 0.0);
        }

        let top = band as u32 * BAND;
        for (piece, outline, rows) in batches.iter().flat_map(|batch| batch.of_band(band)) {
            crossings.spans(outline, rows, |y, from, to, winding| {
                let plane = piece.plane.row::<S::F64x8>(f64::from(y) + 0.5);
                let row = (y - top) as usize * *stride;
                let end = S::F64x8::splat(f64::from(to));
                let step = piece.tag * winding;
                for x in (from as usize..to as usize).step_by(S::F64x8::N) {
                    let at = row + x;
                    let xs = centres::<S::F64x8>(x);
                    let surface = plane.at(xs);
                    let visible = S::F64x8::load(&depths[at..]);
                    // A surface with a smaller q is behind the point. A tie counts as behind where
                    // the line of sight enters a volume.
                    let behind =
                        if winding > 0 { surface.le(visible) } else { surface.lt(visible) };
                    let bits = (behind & xs.lt(end)).bits();
                    if bits == 0 {
                        continue;
                    }
                    let counts = &mut counts[at..at + S::F64x8::N];
                    for (lane, count) in counts.iter_mut().enumerate() {
                        *count += step & -((bits >> lane & 1) as i32);
                    }
                }
            });
        }
    }
}
