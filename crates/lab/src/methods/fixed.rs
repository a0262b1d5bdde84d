//! The `fixed` mode as a method. Each batch has its own integer grid.

use std::time::Instant;

use intertri::fixed::{self, Bits, Grid};
use intertri::simd::Lane;
use intertri::simd::{Level, Simd, WithSimd};
use intertri::{Hit, Ray, Triangle};

use super::closest::Seconds;
use crate::layout::{Form, Layout};
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
            let block = fixed::Block::<8>::new([(triangle, 0)]);
            let hit = fixed::Fixed::at(level).closest(&[block], &ray);
            hit.map_or(Answer::default(), |hit| Answer { hit: true, t: hit.t })
        });
    }
}

/// Finds the closest hits of batches in `fixed` mode, each batch on its own grid. All rays of a
/// batch that does not fit on any grid are misses. Returns `None` unless there are 4 or 8 lanes.
pub(super) fn closest(
    level: Level,
    batches: &[TestBatch],
    layout: Layout,
    nearest: &mut Vec<ClosestHit>,
) -> Option<Seconds> {
    let batches = batches.iter().map(|batch| Snapped::new(batch).unwrap_or(Snapped::none(batch)));
    let batches = batches.collect();
    matches!(layout.lanes, 4 | 8).then(|| level.run(FixedClosest { batches, layout, nearest }))
}

/// Counts how many triangles of its batch each ray crosses in `fixed` mode, or 0 if the batch does
/// not fit on any grid.
pub(super) fn counts(level: Level, batch: &TestBatch) -> Vec<u32> {
    let Some(Snapped { rays, triangles, .. }) = Snapped::new(batch) else {
        return vec![0; batch.rays.len()];
    };
    let blocks: Vec<_> = fixed::blocks(&triangles).collect();
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

struct FixedClosest<'a> {
    batches: Vec<Snapped>,
    layout: Layout,
    nearest: &'a mut Vec<ClosestHit>,
}

impl WithSimd for FixedClosest<'_> {
    type Output = Seconds;

    #[inline(always)]
    fn run<S: Simd>(self) -> Seconds {
        let Self { batches, layout, nearest } = self;
        nearest.clear();
        nearest.reserve(batches.iter().map(|batch| batch.rays.len()).sum());
        match (layout.form, layout.lanes) {
            (Form::Packets, 4) => fixed_packets::<S, 4>(&batches, nearest),
            (Form::Packets, _) => fixed_packets::<S, 8>(&batches, nearest),
            (Form::Blocks, 4) => fixed_blocks::<S, 4>(&batches, nearest),
            (Form::Blocks, _) => fixed_blocks::<S, 8>(&batches, nearest),
        }
    }
}

#[inline(always)]
fn fixed_packets<S: Simd, const N: usize>(
    batches: &[Snapped],
    nearest: &mut Vec<ClosestHit>,
) -> Seconds
where
    Lane<N>: fixed::IntWidth,
{
    let prepared: Vec<(Vec<fixed::Packet<N>>, Vec<fixed::Prepared>)> = batches
        .iter()
        .map(|batch| {
            let packets = batch.rays.chunks(N).map(fixed::Packet::new).collect();
            (packets, batch.triangles.iter().map(fixed::Prepared::new).collect())
        })
        .collect();

    let start = Instant::now();
    for ((packets, triangles), batch) in prepared.iter().zip(batches) {
        for packet in packets {
            let mut bests = [fixed::Best::default(); N];
            for (number, triangle) in (0..).zip(triangles) {
                packet.crossings_in::<S, true>(triangle, packet.live(), |lane, crossing| {
                    bests[lane].offer(crossing, number);
                });
            }
            let live = packet.live().count_ones() as usize;
            for (best, ray) in bests.iter().zip(packet.rays()).take(live) {
                let hit = best.to_hit(ray);
                nearest.push(closest_hit(hit));
            }
        }
        nearest.extend((0..batch.misses).map(|_| ClosestHit::MISS));
    }
    start.elapsed().as_secs_f64()
}

#[inline(always)]
fn fixed_blocks<S: Simd, const N: usize>(
    batches: &[Snapped],
    nearest: &mut Vec<ClosestHit>,
) -> Seconds
where
    Lane<N>: fixed::IntWidth,
{
    let blocks: Vec<Vec<fixed::Block<N>>> = batches
        .iter()
        .map(|batch| {
            let numbered = batch.triangles.chunks(N).zip((0_u32..).step_by(N));
            let block = |(chunk, first): (&[fixed::Triangle], u32)| {
                fixed::Block::new(chunk.iter().copied().zip(first..))
            };
            numbered.map(block).collect()
        })
        .collect();

    let start = Instant::now();
    for (blocks, batch) in blocks.iter().zip(batches) {
        for ray in &batch.rays {
            let lanes = fixed::RayLanes::<S, N>::new(ray);
            let mut best = fixed::Best::default();
            for block in blocks {
                block.crossings_in::<S, true>(&lanes, |crossing, number| {
                    best.offer(crossing, number);
                });
            }
            let hit = best.to_hit(ray);
            nearest.push(closest_hit(hit));
        }
        nearest.extend((0..batch.misses).map(|_| ClosestHit::MISS));
    }
    start.elapsed().as_secs_f64()
}

/// Converts a hit to the type that batches use.
#[inline(always)]
fn closest_hit(hit: Option<Hit>) -> ClosestHit {
    hit.map_or(ClosestHit::MISS, |hit| ClosestHit { t: hit.t, triangle: hit.triangle })
}
