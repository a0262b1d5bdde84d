//! The `fixed` engine: snaps a scene to an integer grid, and traces the snapped scene exactly.

use intertri::fixed::{Bits, Grid, GridError, Ray as Snapped};
use intertri::{Crossing, Hit, Ray, Triangle};
use intertri_trace::Bvh;
use rayon::prelude::*;
use serde::Serialize;

use crate::engine::memory::{self, room};
use crate::error::Result;
use crate::io::progress::Progress;

/// The number of rays that a thread snaps and traces at a time.
const CHUNK: usize = 4096;

/// A scene on a grid.
pub(crate) struct FixedScene {
    grid: Grid,
    /// The hierarchy over the snapped triangles, in grid units: integers, which are exact in f32.
    bvh: Bvh,
    /// A ray with an empty interval, which replaces rays that cannot be snapped.
    never: Snapped,
    /// The largest distance by which snapping moved a point along an axis.
    moved: f64,
}

impl FixedScene {
    /// Snaps triangles to the finest grid that contains the triangles and the points `more`, which
    /// bound the ray origins. Non-finite points are skipped: as in every engine, rays from such
    /// points hit nothing.
    pub(crate) fn new(triangles: &[Triangle], more: &[[f32; 3]], bits: Bits) -> Result<Self> {
        let more = more.iter().copied().filter(|p| p.iter().all(|x| x.is_finite()));
        let points = triangles.iter().flat_map(|t| t.0).chain(more);
        let grid = Grid::around(points.clone(), bits)?;
        let mut snapped: Vec<Triangle> = room(triangles.len(), "triangles")?;
        for triangle in triangles {
            snapped.push(grid.triangle(triangle)?.to_f32());
        }
        let mut moved: f64 = 0.0;
        for point in points {
            moved = moved.max(grid.moved(point)?);
        }

        let bar = Progress::new("build", Some(triangles.len() as u64));
        let bvh = Bvh::with_progress(&snapped, &|done, total| bar.set(done, total))?;
        let never = grid.ray_of([0; 3], [1, 0, 0])?.between(0.0, 0.0);
        Ok(Self { grid, bvh, never, moved })
    }

    /// Returns the nearest grid point, in scene coordinates. A point outside the grid is unchanged.
    pub(crate) fn place(&self, p: [f32; 3]) -> [f32; 3] {
        // A snapped point is exact in f32.
        self.grid.snap(p).map_or(p, |i| self.grid.unsnap(i).map(|x| x as f32))
    }

    /// Returns whether a point is outside the grid, so that rays from it hit nothing. Non-finite
    /// points do not count as outside.
    pub(crate) fn is_outside(&self, p: [f32; 3]) -> bool {
        matches!(self.grid.snap(p), Err(GridError::Outside(_)))
    }

    /// Finds the closest hit of each ray.
    pub(crate) fn closest(&self, rays: &[Ray], hits: &mut [Hit]) {
        self.chunks(rays, hits, |snapped, lines, hits| {
            self.bvh.query().once().closest_batch_into(lines, hits);
            for (hit, ray) in hits.iter_mut().zip(snapped) {
                hit.t = ray.t_of_caller(hit.t);
            }
        });
    }

    /// Finds whether each ray hits anything.
    pub(crate) fn any(&self, rays: &[Ray], hits: &mut [bool]) {
        self.chunks(rays, hits, |_, lines, hits| {
            self.bvh.query().once().any_batch_into(lines, hits);
        });
    }

    /// Returns every hit of a ray, ordered by t, then by triangle.
    pub(crate) fn all(&self, ray: &Ray) -> Result<Vec<Hit>> {
        let crossings = self.crossings(ray)?;
        let mut hits = room(crossings.len(), "hits")?;
        hits.extend(crossings.iter().map(|crossing| crossing.hit));
        Ok(hits)
    }

    /// Returns every crossing of a ray, with its side: whether the ray enters or leaves.
    pub(crate) fn crossings(&self, ray: &Ray) -> Result<Vec<Crossing>> {
        let ray = self.grid.ray(ray).unwrap_or(self.never);
        let mut crossings = memory::crossings(self.bvh.query(), ray.to_f32())?;
        for Crossing { hit, .. } in &mut crossings {
            hit.t = ray.t_of_caller(hit.t);
        }
        Ok(crossings)
    }

    /// Snaps rays to the grid and traces them, in chunks that stay in the cache. `trace` gets the
    /// snapped rays, both as integers and in f32.
    fn chunks<T: Send>(
        &self,
        rays: &[Ray],
        answers: &mut [T],
        trace: impl Fn(&[Snapped], &[Ray], &mut [T]) + Sync,
    ) {
        let chunks = rays.par_chunks(CHUNK).zip(answers.par_chunks_mut(CHUNK));
        let buffers = || (vec![self.never; CHUNK], Vec::with_capacity(CHUNK));
        chunks.for_each_init(buffers, |(snapped, lines), (rays, answers)| {
            let snapped = &mut snapped[..rays.len()];
            self.grid.rays(rays, snapped, |_, _| self.never);
            lines.clear();
            lines.extend(snapped.iter().map(|ray| *ray.to_f32()));
            trace(snapped, lines, answers);
        });
    }

    /// Returns the report about the grid.
    pub(crate) fn report(&self) -> GridReport {
        let (bits, step) = (self.grid.bits(), self.grid.step());
        // Snapping a direction changes each component by less than 2^-q of the longest component,
        // so a ray that crosses the whole grid deviates by less than 2^-q of the grid's size.
        let across = step * f64::from(2_u32 << bits.b());
        let strays = across / f64::from(1_u32 << bits.q());
        GridReport { bits: bits.b(), direction_bits: bits.q(), step, moved: self.moved, strays }
    }
}

/// The properties of a grid, for reports. Lengths are in scene units.
#[derive(Clone, Copy, Serialize)]
pub(crate) struct GridReport {
    pub(crate) bits: u32,
    pub(crate) direction_bits: u32,
    /// The distance between neighbouring grid points.
    pub(crate) step: f64,
    /// The largest distance by which snapping moved a point along an axis.
    pub(crate) moved: f64,
    /// An upper bound, along each axis, on the distance by which the end of a ray across the whole
    /// grid is displaced, because its direction is also snapped.
    pub(crate) strays: f64,
}
