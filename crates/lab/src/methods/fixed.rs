//! The `fixed` mode as a method. Each batch has its own integer grid.

use intertri::fixed::{self, Bits, Grid};
use intertri::simd::Level;
use intertri::{Mode, Ray, Triangle};

use super::closest::Seconds;
use super::kernel;
use crate::layout::Layout;
use crate::test_batch::{Answer, ClosestHit, TestBatch};

/// Tests pairs in `fixed` mode, each on the finest grid that can represent it. A pair that fits on
/// no grid is a miss.
pub(super) fn pairs(level: Level, triangles: &[Triangle], rays: &[Ray], to: &mut [Answer]) {
    for ((triangle, ray), to) in triangles.iter().zip(rays).zip(to) {
        let whole = Ray::new(ray.origin, ray.dir);
        let points = triangle.0.into_iter().chain([ray.origin]);
        let snapped = Grid::around(points, Bits::FINE)
            .and_then(|grid| Ok((grid.triangle(triangle)?, grid.ray(&whole)?)));
        *to = snapped.map_or(Answer::default(), |(triangle, ray)| {
            let hit = Mode::once().at(level).closest(&[triangle.to_f32()], ray.to_f32());
            hit.map_or(Answer::default(), |hit| Answer { hit: true, t: ray.t_of_caller(hit.t) })
        });
    }
}

/// Finds the closest hits of batches in `fixed` mode, each batch on its own grid. All rays of a
/// batch that does not fit on any grid are misses. Snapping is not timed.
pub(super) fn closest(
    level: Level,
    batches: &[TestBatch],
    layout: Layout,
    nearest: &mut Vec<ClosestHit>,
) -> Option<Seconds> {
    let snapped: Vec<Snapped> =
        batches.iter().map(|batch| Snapped::new(batch).unwrap_or(Snapped::none(batch))).collect();
    let in_f32: Vec<TestBatch> = snapped.iter().map(Snapped::to_f32).collect();
    let mut found = Vec::new();
    let seconds = kernel::closest(Mode::once().at(level), level, &in_f32, layout, &mut found)?;
    nearest.clear();
    let mut found = found.into_iter();
    for batch in &snapped {
        let of_caller =
            |(ray, hit): (&fixed::Ray, ClosestHit)| ClosestHit { t: ray.t_of_caller(hit.t), ..hit };
        nearest.extend(batch.rays.iter().zip(found.by_ref()).map(of_caller));
        nearest.extend((0..batch.misses).map(|_| ClosestHit::MISS));
    }
    Some(seconds)
}

/// Counts how many triangles of its batch each ray crosses in `fixed` mode, or 0 if the batch does
/// not fit on any grid.
pub(super) fn counts(level: Level, batch: &TestBatch) -> Vec<u32> {
    let Some(Snapped { rays, triangles, .. }) = Snapped::new(batch) else {
        return vec![0; batch.rays.len()];
    };
    let blocks = fixed::blocks(&triangles);
    let count = |ray| fixed::Fixed::at(level).crossings(&blocks, ray).unsigned as u32;
    rays.iter().map(count).collect()
}

/// A batch on its own grid.
struct Snapped {
    rays: Vec<fixed::Ray>,
    triangles: Vec<fixed::Triangle>,
    /// The number of rays if the batch does not fit on any grid, in which case all rays count as
    /// misses; otherwise 0.
    misses: usize,
}

impl Snapped {
    fn new(batch: &TestBatch) -> Option<Self> {
        let grid = grid(batch)?;
        let rays: Result<Vec<_>, _> = batch.rays.iter().map(|ray| grid.ray(ray)).collect();
        let triangles: Result<_, _> = batch.triangles.iter().map(|t| grid.triangle(t)).collect();
        Some(Self { rays: rays.ok()?, triangles: triangles.ok()?, misses: 0 })
    }

    /// Creates a batch in which every ray misses.
    fn none(batch: &TestBatch) -> Self {
        Self { rays: Vec::new(), triangles: Vec::new(), misses: batch.rays.len() }
    }

    fn to_f32(&self) -> TestBatch {
        TestBatch {
            rays: self.rays.iter().map(|ray| *ray.to_f32()).collect(),
            triangles: self.triangles.iter().map(fixed::Triangle::to_f32).collect(),
        }
    }
}

/// Returns the finest grid that can represent a batch.
fn grid(batch: &TestBatch) -> Option<Grid> {
    let origins = batch.rays.iter().map(|ray| ray.origin);
    Grid::around(batch.triangles.iter().flat_map(|t| t.0).chain(origins), Bits::FINE).ok()
}

/// Returns the batch that the `fixed` mode effectively tests: snapped to a grid and converted back
/// to f32 without rounding. The answers of `fixed` are exact for the returned batch. Returns `None`
/// if the batch does not fit on any grid.
pub fn on_grid(batch: &TestBatch) -> Option<TestBatch> {
    let grid = grid(batch)?;
    let back = |p| Some(grid.unsnap(grid.snap(p).ok()?).map(|x| x as f32));
    let ray = |ray: &Ray| {
        let dir = grid.ray(ray).ok()?.dir().map(|x| x as f32);
        Some(Ray::new(back(ray.origin)?, dir))
    };
    let triangle = |t: &Triangle| {
        let [a, b, c] = t.0.map(back);
        Some(Triangle([a?, b?, c?]))
    };
    Some(TestBatch {
        rays: batch.rays.iter().map(ray).collect::<Option<_>>()?,
        triangles: batch.triangles.iter().map(triangle).collect::<Option<_>>()?,
    })
}
