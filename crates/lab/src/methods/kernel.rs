//! The kernel's modes `certified` and `double` as methods, in the same forms as the published ones.

use std::time::Instant;

use intertri::internal::Pairs;
use intertri::simd::{Lane, Level, Simd, Width, WithSimd};
use intertri::{
    self as kernel, ClosestHits, Counts, LaneQueries, Mode, PacketHits, Prepared, PreparedPacket,
    Ray, RayPacket, Triangle, TriangleBlock,
};

use super::closest::{Seconds, one_register, packets_of, rays_of};
use crate::layout::{Form, Layout};
use crate::test_batch::{Answer, ClosestHit, TestBatch};

/// A mode of the kernel on pairs: each ray a packet of its own.
pub(super) fn pairs<M: Mode>(mode: M, triangles: &[Triangle], rays: &[Ray], to: &mut [Answer]) {
    for ((triangle, ray), to) in triangles.iter().zip(rays).zip(to) {
        let whole = Ray::new(ray.origin, ray.dir);
        let hits = mode.packet(&RayPacket::<4>::new(&[whole]), &mode.prepare(triangle));
        *to = Answer { hit: hits.bits & 1 == 1, t: hits.t[0] };
    }
}

/// The closest hits of batches, by a mode; `None` for one lane, which the reference is there for, and
/// for 16 where they are no packets or not one register.
pub(super) fn closest<M: Mode>(
    mode: M,
    level: Level,
    batches: &[TestBatch],
    layout: Layout,
    nearest: &mut Vec<ClosestHit>,
) -> Option<Seconds> {
    let has = layout.lanes > 1;
    has.then(|| level.run(Closest { test: mode.test(), batches, layout, nearest })).flatten()
}

struct Closest<'a, T> {
    test: T,
    batches: &'a [TestBatch],
    layout: Layout,
    nearest: &'a mut Vec<ClosestHit>,
}

impl<T: LaneQueries> WithSimd for Closest<'_, T> {
    type Output = Option<Seconds>;

    #[inline(always)]
    fn run<S: Simd>(self) -> Option<Seconds> {
        let Self { test, batches, layout, nearest } = self;
        nearest.clear();
        nearest.reserve(rays_of(batches, 0));
        match (layout.form, layout.lanes) {
            (Form::Packets, 4) => Some(packets::<T, S, 4>(test, batches, nearest)),
            (Form::Packets, 8) => Some(packets::<T, S, 8>(test, batches, nearest)),
            (Form::Blocks, 4) => Some(blocks_of_4::<T, S>(test, batches, nearest)),
            (Form::Blocks, 8) => Some(blocks_of_8::<T, S>(test, batches, nearest)),
            (Form::Packets, _) if const { one_register::<S>() } => {
                Some(packets::<T, S, 16>(test, batches, nearest))
            }
            _ => None,
        }
    }
}

/// N rays against one triangle after another: `t` enclosed in f32 while they run, exact at the end.
#[inline(always)]
fn packets<T: LaneQueries, S: Simd, const N: usize>(
    test: T,
    batches: &[TestBatch],
    nearest: &mut Vec<ClosestHit>,
) -> Seconds
where
    Lane<N>: Width,
{
    let (packets, triangles) = (packets_of::<N>(batches), triangles_of(&test, batches));
    let mut counts = Counts::default();

    let start = Instant::now();
    for (i, batch) in batches.iter().enumerate() {
        let (packets, triangles) = (&packets[i], &triangles[i]);
        let find = |place: u32| batch.triangles[place as usize];
        for packet in packets {
            let rays = test.prepare_packet_in::<S, N>(packet);
            let mut bests = ClosestHits::new(&packet.t_max);
            let live = packet.live();
            test.packet_closest_of_in(&rays, triangles, 0, find, live, &mut bests, &mut counts);
            answers::<T, S, N>(&test, &rays, &bests, find, live, nearest);
        }
    }
    start.elapsed().as_secs_f64()
}

/// The triangles of each batch, prepared.
#[inline(never)]
fn triangles_of<T: LaneQueries>(test: &T, batches: &[TestBatch]) -> Vec<Vec<Prepared<T>>> {
    batches.iter().map(|batch| batch.triangles.iter().map(|t| test.prepare(t)).collect()).collect()
}

/// One ray after another against eight triangles at a time.
#[inline(always)]
fn blocks_of_8<T: LaneQueries, S: Simd>(
    test: T,
    batches: &[TestBatch],
    nearest: &mut Vec<ClosestHit>,
) -> Seconds {
    let blocks = blocks::<8>(batches);
    let mut counts = Counts::default();

    let start = Instant::now();
    for (blocks, batch) in blocks.iter().zip(batches) {
        let find = |place: u32| batch.triangles[place as usize];
        let mut waiting = Waiting::new();
        for ray in &batch.rays {
            let lanes = test.prepare_ray(ray);
            let mut best = kernel::ClosestHit::new(f32::INFINITY);
            for (k, block) in (0..).step_by(8).zip(blocks) {
                let numbers = std::array::from_fn(|lane| k + lane as u32);
                test.closest_in::<S>(&lanes, block, &numbers, k, find, &mut best, &mut counts);
            }
            nearest.push(ClosestHit::MISS);
            if let Some((triangle, place)) = best.triangle() {
                waiting.add::<T, S>(&test, (ray, &find(place), triangle), nearest);
            }
        }
        waiting.answer::<T, S>(&test, nearest);
    }
    start.elapsed().as_secs_f64()
}

/// Hits of single rays that wait until t of eight of them is computed side by side, as in the streams of a
/// hierarchy.
struct Waiting {
    pairs: Pairs,
    numbers: [usize; 8],
    len: usize,
}

impl Waiting {
    fn new() -> Self {
        Self { pairs: Pairs::new(), numbers: [0; 8], len: 0 }
    }

    /// The last of the answers is that of a ray and a triangle which it hits.
    #[inline(always)]
    fn add<T: LaneQueries, S: Simd>(
        &mut self,
        test: &T,
        (ray, triangle, index): (&Ray, &Triangle, u32),
        nearest: &mut [ClosestHit],
    ) {
        self.pairs.set(self.len, ray, triangle, index);
        self.numbers[self.len] = nearest.len() - 1;
        self.len += 1;
        if self.len == 8 {
            self.answer::<T, S>(test, nearest);
        }
    }

    /// Answers all that wait.
    #[inline(always)]
    fn answer<T: LaneQueries, S: Simd>(&mut self, test: &T, nearest: &mut [ClosestHit]) {
        // No originals here, which alone would ask for the pairs' numbers.
        let hits = test.resolver().hits_in::<S>(&self.pairs, &[(0, 0); 8], self.len);
        for (hit, &number) in hits.into_iter().zip(&self.numbers[..self.len]) {
            nearest[number] = ClosestHit { t: hit.t, triangle: hit.triangle };
        }
        self.len = 0;
    }
}

/// One ray after another against four triangles at a time.
#[inline(always)]
fn blocks_of_4<T: LaneQueries, S: Simd>(
    test: T,
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
                let hits = test.block_in::<S, 4>(ray, block, &mut counts);
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

/// The answers of a packet, t of all of them side by side.
#[inline(always)]
pub(super) fn answers<T: LaneQueries, S: Simd, const N: usize>(
    test: &T,
    rays: &PreparedPacket<'_, T, S, N>,
    closest: &ClosestHits<<Lane<N> as Width>::F<S>, N>,
    find: impl Fn(u32) -> Triangle,
    live: u32,
    nearest: &mut Vec<ClosestHit>,
) where
    Lane<N>: Width,
{
    let hits = test.hits_in(rays, closest, find);
    for lane in 0..live.count_ones() as usize {
        let triangle = closest.lane(lane).triangle();
        let hit = |(triangle, _)| ClosestHit { t: hits.t[lane], triangle };
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
