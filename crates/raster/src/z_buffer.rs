//! Document B: finds the facet that each pixel shows, which is the nearest facet at its centre.
//!
//! 1. Every facet is clipped, snapped to fractions of a pixel, and sorted into bands of rows.
//! 2. In each band, each row of a facet becomes runs of pixels, which integer winding numbers
//!    determine. Each pixel in a run stores the facet if it is nearer than the facet already
//!    stored.
//! 3. The facet that remains in a pixel becomes a [`Hit`] in f64.

use intertri::internal::Coefficients;
use intertri::simd::{Lanes, Mask, Simd, WithSimd, dispatch};
use intertri::{Hit, Triangle};

use crate::batch::{Batch, batches};
use crate::plane::{FacetPlane, range};
use crate::spans::{BAND, Crossings};
use crate::threads;
use crate::vector::{Vector, add, cross, dot, double, sub};
use crate::view::{PixelDirections, View};

/// An image must have fewer facets than this number.
const MAX_FACETS: usize = i32::MAX as usize;

/// Returns the facet that each pixel of a view shows, row by row from the top left.
///
/// A facet is an outline with three or more corners in one plane. It may be convex or concave, may
/// have either winding, and is two-sided. It covers the pixels whose centres its outline winds
/// around. A centre exactly on an edge belongs to the facet to its right, or below it. Therefore,
/// if two facets share an edge and lie on opposite sides of it in the image, exactly one of them
/// covers a centre on that edge. An outline that crosses itself covers the points with a nonzero
/// winding number.
///
/// - `triangle` of a [`Hit`] is the facet's index in the slice.
/// - `t` is the distance from the eye, which is the `t` of a ray whose direction has unit length.
///   It is computed from the view depth of the facet's plane, which is limited to the range of the
///   corners' view depths. Only points with `t > threshold` are visible, as with the threshold of
///   rays. The facet with the smallest `t` owns the pixel. If several have the same `t`, the facet
///   with the lowest index does.
/// - `u` and `v` are the weights of the second and third corners: a point in the facet's plane is
///   `c1 + u (c2 - c1) + v (c3 - c1)`, even for a facet with more corners.
///
/// A facet is invisible if it has fewer than three corners or a NaN or infinite coordinate, if it
/// is degenerate (its corners' cross products sum to 0), or if the eye is in its plane. For an
/// outline that is not flat, the plane has the mean normal and passes through the first corner.
///
/// # Panics
/// Panics if there are 2^31 - 1 facets or more, or if `threshold` is negative, infinite, or NaN.
///
/// ```
/// use intertri_raster::{View, facets};
/// let axes = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, -1.0]];
/// let view = View::new([0.0; 3], axes, 1.0, 9, 9).unwrap();
/// let square = [[-1.0, -1.0, -4.0], [1.0, -1.0, -4.0], [1.0, 1.0, -4.0], [-1.0, 1.0, -4.0]];
/// let hits = facets(&view, &[square], 1e-9);
/// assert_eq!((hits[4 * 9 + 4].triangle, hits[4 * 9 + 4].t), (0, 4.0));
/// assert!(!hits[0].is_hit());
/// ```
pub fn facets<F>(view: &View, facets: &[F], threshold: f64) -> Vec<Hit>
where
    F: AsRef<[[f32; 3]]> + Sync,
{
    assert!(facets.len() < MAX_FACETS, "there must be fewer than 2^31 - 1 facets");
    assert!(
        threshold >= 0.0 && threshold.is_finite(),
        "the threshold must be finite and must not be negative"
    );
    let near = (threshold / view.longest()).max(f64::MIN_POSITIVE);
    let directions = view.pixel_directions();
    let batches = batches(view, facets.len(), |batch, i| {
        prepare(batch, view, &directions, facets[i].as_ref(), near, i as i32);
    });

    let width = view.width() as usize;
    let mut hits = vec![Hit::MISS; width * view.height() as usize];
    threads::parts(&mut hits, width * BAND as usize, |band, hits, buffer: &mut Buffer| {
        dispatch(Draw {
            batches: &batches,
            directions: &directions,
            band,
            width,
            threshold,
            buffer,
        });
        for (row, hits) in hits.chunks_mut(width).enumerate() {
            let y = band as u32 * BAND + row as u32;
            let mut last: Option<(usize, Coefficients)> = None;
            for (x, hit) in hits.iter_mut().enumerate() {
                let at = row * buffer.stride + x;
                let Ok(facet) = usize::try_from(buffer.facet[at]) else { continue };
                // Neighbouring pixels mostly show the same facet.
                if last.is_none_or(|(same, _)| same != facet) {
                    last = Some((facet, coefficients(view, facets[facet].as_ref())));
                }
                if let Some((_, seen)) = &last {
                    *hit = resolve(view, seen, facet, buffer.q[at], x as u32, y);
                }
            }
        }
    });
    hits
}

/// Like [`facets`], but for triangles.
///
/// # Panics
/// Panics under the same conditions as [`facets`].
pub fn triangles(view: &View, triangles: &[Triangle], threshold: f64) -> Vec<Hit> {
    facets::<[[f32; 3]; 3]>(view, bytemuck::cast_slice(triangles), threshold)
}

/// Returns the plane of a facet, or `None` if the facet is degenerate or the eye is in its plane.
/// The plane's normal is the sum of the cross products over the fan around the first corner, as in
/// the reference implementation.
pub(crate) fn plane<C>(view: &View, directions: &PixelDirections, corners: C) -> Option<FacetPlane>
where
    C: IntoIterator<Item = Vector, IntoIter: Clone>,
{
    let mut corners = corners.into_iter();
    let depths = range(corners.clone().map(|corner| view.depth(sub(corner, view.eye()))));
    let c1 = corners.next()?;
    let mut arms = corners.map(|corner| sub(corner, c1));
    let mut before = arms.next()?;
    let mut normal = [0.0; 3];
    for arm in arms {
        normal = add(normal, cross(before, arm));
        before = arm;
    }
    let arm = sub(c1, view.eye());
    (dot(normal, arm) != 0.0).then(|| FacetPlane::new(directions, normal, arm, depths))
}

/// Clips and snaps one facet, and adds it to the batch (step 1).
fn prepare(
    batch: &mut Batch,
    view: &View,
    directions: &PixelDirections,
    corners: &[[f32; 3]],
    near: f64,
    tag: i32,
) {
    if corners.len() < 3 || !corners.as_flattened().iter().all(|x| x.is_finite()) {
        return;
    }
    let outline = corners.iter().map(|&c| view.project(sub(double(c), view.eye()), 1.0, near));
    batch.push(view, outline, tag, || plane(view, directions, corners.iter().copied().map(double)));
}

/// The pixels of one band. Each row is padded to fill the last lanes.
#[derive(Default)]
struct Buffer {
    stride: usize,
    q: Vec<f64>,
    facet: Vec<i32>,
    crossings: Crossings,
}

/// Draws the facets of one band (step 2).
struct Draw<'a> {
    batches: &'a [Batch],
    directions: &'a PixelDirections,
    band: usize,
    width: usize,
    threshold: f64,
    buffer: &'a mut Buffer,
}

impl WithSimd for Draw<'_> {
    type Output = ();

    #[inline(always)]
    fn run<S: Simd>(self) {
        let Self { batches, directions, band, width, threshold, buffer } = self;
        let Buffer { stride, q, facet, crossings } = buffer;
        *stride = width + S::F64x8::N;
        q.clear();
        q.resize(*stride * BAND as usize, 0.0);
        facet.clear();
        facet.resize(*stride * BAND as usize, -1);

        let top = band as u32 * BAND;
        for (piece, outline, rows) in batches.iter().flat_map(|batch| batch.of_band(band)) {
            // Only a facet that comes this close can have points nearer than the threshold: t = |d|
            // / q, and |d| >= 1.
            let close = piece.plane.hi() * threshold >= 1.0;
            crossings.spans(outline, rows, |y, from, to, _| {
                let centre = f64::from(y) + 0.5;
                let plane = piece.plane.row::<S::F64x8>(centre);
                let row = (y - top) as usize * *stride;
                let end = S::F64x8::splat(f64::from(to));
                for x in (from as usize..to as usize).step_by(S::F64x8::N) {
                    let at = row + x;
                    let xs = centres::<S::F64x8>(x);
                    let new = plane.at(xs);
                    let old = S::F64x8::load(&q[at..]);
                    let mut nearer = new.gt(old) & xs.lt(end);
                    if close {
                        let d = lengths(directions, xs, centre);
                        nearer = nearer & (new * S::F64x8::splat(threshold)).lt(d);
                    }
                    let bits = nearer.bits();
                    if bits == 0 {
                        continue;
                    }
                    S::F64x8::select(nearer, new, old).store(&mut q[at..]);
                    for lane in 0..S::F64x8::N {
                        if bits >> lane & 1 == 1 {
                            facet[at + lane] = piece.tag;
                        }
                    }
                }
            });
        }
    }
}

/// Returns the x coordinates of the centres of a pixel and the pixels after it, one per lane.
#[inline(always)]
pub(crate) fn centres<D: Lanes<Scalar = f64>>(x: usize) -> D {
    const STEPS: [f64; 16] = {
        let mut steps = [0.5; 16];
        let mut i = 0;
        while i < 16 {
            steps[i] += i as f64;
            i += 1;
        }
        steps
    };
    D::splat(x as f64) + D::load(&STEPS)
}

/// Computes `|d|` for the lines of sight through these pixel centres in a row.
#[inline(always)]
fn lengths<D: Lanes<Scalar = f64>>(directions: &PixelDirections, x: D, y: f64) -> D {
    let d = |axis: usize| {
        D::splat(directions.dx[axis]) * x
            + D::splat(directions.origin[axis] + directions.dy[axis] * y)
    };
    let (dx, dy, dz) = (d(0), d(1), d(2));
    (dx * dx + dy * dy + dz * dz).sqrt()
}

/// Computes the coefficients for the weights of a facet's second and third corners (document D).
fn coefficients(view: &View, corners: &[[f32; 3]]) -> Coefficients {
    let first = Triangle([corners[0], corners[1], corners[2]]);
    Coefficients::new(&first, view.eye().map(|x| x as f32))
}

/// Computes the hit of one pixel from its facet and its inverse view depth (step 3).
fn resolve(view: &View, seen: &Coefficients, facet: usize, q: f64, x: u32, y: u32) -> Hit {
    let (d, long) = view.through(x, y);
    let (u, v) = seen.weights(d);
    // If a facet's first three corners are collinear, the weights are not finite.
    let weight = |w: f64| if w.is_finite() { w } else { 0.0 };
    Hit { t: long / q, u: weight(u), v: weight(v), triangle: facet as u32, geometry: 0 }
}

#[cfg(test)]
mod tests {
    use super::*;
    use intertri::simd::Level;

    fn random(state: &mut u64) -> f64 {
        *state =
            state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (*state >> 11) as f64 / (1u64 << 52) as f64 - 1.0
    }

    fn ahead(width: u32, height: u32) -> View {
        let axes = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, -1.0]];
        View::new([0.0; 3], axes, 1.0, width, height).unwrap()
    }

    #[test]
    fn every_level_of_instructions_draws_the_same_bits() {
        let view = ahead(83, 31);
        let directions = view.pixel_directions();
        let mut state = 1;
        let soup: Vec<[[f32; 3]; 3]> = (0..300)
            .map(|_| [(); 3].map(|()| [(); 3].map(|()| (random(&mut state) * 3.0) as f32)))
            .collect();
        let batches = batches(&view, soup.len(), |batch, i| {
            prepare(batch, &view, &directions, &soup[i], 1e-9, i as i32);
        });
        for band in 0..2 {
            let drawn: Vec<_> = Level::all()
                .map(|level| {
                    let mut buffer = Buffer::default();
                    let (width, threshold) = (83, 0.5);
                    let (batches, buffer_) = (&batches[..], &mut buffer);
                    level.run(Draw {
                        batches,
                        directions: &directions,
                        band,
                        width,
                        threshold,
                        buffer: buffer_,
                    });
                    (buffer.q.iter().map(|q| q.to_bits()).collect::<Vec<_>>(), buffer.facet)
                })
                .collect();
            assert!(drawn.iter().all(|one| *one == drawn[0]));
            assert!(drawn[0].1.iter().any(|facet| *facet >= 0));
        }
    }

    #[test]
    fn a_closed_surface_is_crossed_as_often_one_way_as_the_other() {
        // The tetrahedra are random; some enclose the eye or straddle the plane through the eye
        // parallel to the image. The windings of the four faces, clipped and snapped, have the same
        // sum at every pixel: 0, or -1 if the eye is inside and sees only back faces, or +1 if the
        // tetrahedron is also inside out.
        let view = ahead(40, 40);
        let mut state = 2;
        let mut around = 0;
        for _ in 0..2000 {
            let [a, b, c, d] =
                [(); 4].map(|()| [(); 3].map(|()| (random(&mut state) * 2.0) as f32));
            let faces = [[a, b, c], [a, d, b], [b, d, c], [c, d, a]];
            let batches = batches(&view, 4, |batch, i| {
                let corners = faces[i].map(double);
                let outline = corners.map(|corner| view.project(corner, 1.0, 1e-12));
                batch.push(&view, outline, 0, || Some(FacetPlane::flat(1.0)));
            });
            let mut sums = vec![0; 40 * 40];
            let mut crossings = Crossings::default();
            for band in 0..3 {
                for (_, outline, rows) in batches.iter().flat_map(|batch| batch.of_band(band)) {
                    crossings.spans(outline, rows, |y, from, to, winding| {
                        for x in from..to {
                            sums[(y * 40 + x) as usize] += winding;
                        }
                    });
                }
            }
            assert!(sums.iter().all(|sum| *sum == sums[0]), "{faces:?}");
            around += usize::from(sums[0] != 0);
        }
        assert!(around > 10, "{around}");
    }
}
