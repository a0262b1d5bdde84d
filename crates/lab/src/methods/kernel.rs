//! The kernel's modes as methods, in the same forms as the published methods.

use std::time::Instant;

use intertri::internal::Pairs;
use intertri::simd::{Lane, Level, Simd, Width, WithSimd};
use intertri::{
    self as kernel, ClosestHits, Counts, Filter, LeafSlot, Mode, PacketHits, PreparedPacket,
    PreparedTriangle, Ray, RayId, RayPacket, Triangle, TriangleBlock, TriangleId,
};

use super::closest::{Seconds, one_register, packets_of, rays_of};
use crate::layout::{Form, Layout};
use crate::test_batch::{Answer, ClosestHit, TestBatch};

/// Tests pairs in one of the kernel's modes, putting each ray in a packet of its own.
pub(super) fn pairs(mode: Mode, triangles: &[Triangle], rays: &[Ray], to: &mut [Answer]) {
    for ((triangle, ray), to) in triangles.iter().zip(rays).zip(to) {
        let whole = Ray::new(ray.origin, ray.dir);
        let hits = mode.packet(&RayPacket::<4>::new(&[whole]), &PreparedTriangle::new(triangle));
        *to = Answer { hit: hits.bits & 1 == 1, t: hits.t[0] };
    }
}

/// Finds the closest hits of batches in one of the kernel's modes. Returns `None` for one lane,
/// which the reference implementation covers, and for 16 lanes, except in packets if 16 values fit
/// in one register.
pub(super) fn closest(
    mode: Mode,
    level: Level,
    batches: &[TestBatch],
    layout: Layout,
    nearest: &mut Vec<ClosestHit>,
) -> Option<Seconds> {
    let has = layout.lanes > 1;
    has.then(|| level.run(Closest { filter: mode.filter(), batches, layout, nearest })).flatten()
}

struct Closest<'a> {
    filter: Filter<'a>,
    batches: &'a [TestBatch],
    layout: Layout,
    nearest: &'a mut Vec<ClosestHit>,
}

impl WithSimd for Closest<'_> {
    type Output = Option<Seconds>;

    #[inline(always)]
    fn run<S: Simd>(self) -> Option<Seconds> {
        let Self { filter, batches, layout, nearest } = self;
        nearest.clear();
        nearest.reserve(rays_of(batches, 0));
        match (layout.form, layout.lanes) {
            (Form::Packets, 4) => Some(packets::<S, 4>(filter, batches, nearest)),
            (Form::Packets, 8) => Some(packets::<S, 8>(filter, batches, nearest)),
            (Form::Blocks, 4) => Some(blocks_of_4::<S>(filter, batches, nearest)),
            (Form::Blocks, 8) => Some(blocks_of_8::<S>(filter, batches, nearest)),
            (Form::Packets, _) if const { one_register::<S>() } => {
                Some(packets::<S, 16>(filter, batches, nearest))
            }
            _ => None,
        }
    }
}

/// Tests N rays against one triangle after another. The loop encloses `t` in an f32 interval; the
/// final `t` is computed after the loop.
#[inline(always)]
fn packets<S: Simd, const N: usize>(
    filter: Filter<'_>,
    batches: &[TestBatch],
    nearest: &mut Vec<ClosestHit>,
) -> Seconds
where
    Lane<N>: Width,
{
    let (packets, triangles) = (packets_of::<N>(batches), triangles_of(batches));
    let mut counts = Counts::default();

    let start = Instant::now();
    for (i, batch) in batches.iter().enumerate() {
        let (packets, triangles) = (&packets[i], &triangles[i]);
        let find = |LeafSlot(slot)| batch.triangles[slot as usize];
        for packet in packets {
            let rays = filter.prepare_packet_in::<S, N>(packet);
            let (live, mut bests) = (packet.live(), ClosestHits::new(&packet.t_max));
            filter.packet_closest_of_in(&rays, triangles, live, &mut bests, &mut counts);
            answers::<S, N>(&filter, &rays, &bests, find, live, nearest);
        }
    }
    start.elapsed().as_secs_f64()
}

/// Prepares the triangles of each batch.
#[inline(never)]
fn triangles_of(batches: &[TestBatch]) -> Vec<Vec<PreparedTriangle>> {
    batches
        .iter()
        .map(|batch| batch.triangles.iter().map(PreparedTriangle::new).collect())
        .collect()
}

/// Tests one ray after another against eight triangles at a time.
#[inline(always)]
fn blocks_of_8<S: Simd>(
    filter: Filter<'_>,
    batches: &[TestBatch],
    nearest: &mut Vec<ClosestHit>,
) -> Seconds {
    let blocks = blocks::<8>(batches);
    let mut counts = Counts::default();

    let start = Instant::now();
    for (blocks, batch) in blocks.iter().zip(batches) {
        let find = |LeafSlot(slot)| batch.triangles[slot as usize];
        let mut waiting = WaitingHits::new();
        for ray in &batch.rays {
            let prepared = filter.prepare_ray(ray);
            let mut best = kernel::ClosestHit::new(f32::INFINITY);
            for (k, block) in (0..).step_by(8).zip(blocks) {
                let numbers = std::array::from_fn(|lane| k + lane as u32);
                let first = LeafSlot(k);
                filter.closest_in::<S>(
                    &prepared,
                    block,
                    &numbers,
                    first,
                    find,
                    &mut best,
                    &mut counts,
                );
            }
            nearest.push(ClosestHit::MISS);
            if let Some((triangle, slot)) = best.triangle() {
                waiting.add::<S>(&filter, (ray, &find(slot), triangle), nearest);
            }
        }
        waiting.answer::<S>(&filter, nearest);
    }
    start.elapsed().as_secs_f64()
}

/// Collects hits of single rays until eight hits can be computed together, as ray streams do when
/// they traverse a hierarchy.
struct WaitingHits {
    pairs: Pairs,
    numbers: [usize; 8],
    len: usize,
}

impl WaitingHits {
    fn new() -> Self {
        Self { pairs: Pairs::new(), numbers: [0; 8], len: 0 }
    }

    /// Adds the latest ray's hit with a triangle, which will replace that ray's entry in `nearest`.
    #[inline(always)]
    fn add<S: Simd>(
        &mut self,
        filter: &Filter<'_>,
        (ray, triangle, index): (&Ray, &Triangle, TriangleId),
        nearest: &mut [ClosestHit],
    ) {
        self.pairs.set(self.len, ray, triangle, index);
        self.numbers[self.len] = nearest.len() - 1;
        self.len += 1;
        if self.len == 8 {
            self.answer::<S>(filter, nearest);
        }
    }

    /// Computes all waiting hits.
    #[inline(always)]
    fn answer<S: Simd>(&mut self, filter: &Filter<'_>, nearest: &mut [ClosestHit]) {
        // The IDs of the pairs are needed only to look up original f64 coordinates, which batches
        // do not have.
        let ids = [(RayId(0), LeafSlot(0)); 8];
        let hits = filter.resolver().hits_in::<S>(&self.pairs, &ids, self.len);
        for (hit, &number) in hits.into_iter().zip(&self.numbers[..self.len]) {
            nearest[number] = ClosestHit { t: hit.t, triangle: hit.triangle };
        }
        self.len = 0;
    }
}

/// Tests one ray after another against four triangles at a time.
#[inline(always)]
fn blocks_of_4<S: Simd>(
    filter: Filter<'_>,
    batches: &[TestBatch],
    nearest: &mut Vec<ClosestHit>,
) -> Seconds {
    let blocks = blocks::<4>(batches);
    let mut counts = Counts::default();

    let start = Instant::now();
    for (blocks, batch) in blocks.iter().zip(batches) {
        for ray in &batch.rays {
            let mut best = ClosestHit::MISS;
            for (k, block) in (0..).step_by(4).zip(blocks) {
                let hits = filter.block_in::<S, 4>(ray, block, &mut counts);
                each(&hits, |lane, t| offer(&mut best, t, k + lane as u32));
            }
            nearest.push(best);
        }
    }
    start.elapsed().as_secs_f64()
}

fn blocks<const N: usize>(batches: &[TestBatch]) -> Vec<Vec<TriangleBlock<N>>> {
    batches.iter().map(|b| b.triangles.chunks(N).map(TriangleBlock::new).collect()).collect()
}

/// Stores the closest hits of a packet, computing all t together.
#[inline(always)]
pub(super) fn answers<S: Simd, const N: usize>(
    filter: &Filter<'_>,
    rays: &PreparedPacket<'_, S, N>,
    closest: &ClosestHits<<Lane<N> as Width>::F<S>, N>,
    find: impl Fn(LeafSlot) -> Triangle,
    live: u32,
    nearest: &mut Vec<ClosestHit>,
) where
    Lane<N>: Width,
{
    let hits = filter.hits_in(rays, closest, find);
    for lane in 0..live.count_ones() as usize {
        let triangle = closest.lane(lane).triangle();
        let hit = |(TriangleId(triangle), _)| ClosestHit { t: hits.t[lane], triangle };
        nearest.push(triangle.map_or(ClosestHit::MISS, hit));
    }
}

#[inline(always)]
fn each<const N: usize>(hits: &PacketHits<N>, mut with: impl FnMut(usize, f64))
where
    Lane<N>: Width,
{
    let mut bits = hits.bits;
    while bits != 0 {
        let lane = bits.trailing_zeros() as usize;
        bits &= bits - 1;
        with(lane, hits.t[lane]);
    }
}

#[inline(always)]
fn offer(best: &mut ClosestHit, t: f64, triangle: u32) {
    if t < best.t {
        *best = ClosestHit { t, triangle };
    }
}
