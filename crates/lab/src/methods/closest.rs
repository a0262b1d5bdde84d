//! Finds the closest hits of batches with an intersector. Tests either N rays against one triangle
//! after another (packets), or one ray after another against N triangles (blocks).
//!
//! Values that depend only on the triangle are computed before the timed part and stored as one
//! value per field (packets) or N values per field (blocks). The measured time includes the time to
//! compute values that depend only on the ray. Both forms update the closest hit of each ray
//! without a branch.

use std::time::Instant;

use intertri::simd::Vec3;
use intertri::simd::{Level, Simd, WithSimd};
use intertri::{RayPacket, TriangleBlock};

use super::intersector::Intersector;
use super::real::{Number, Real};
use crate::layout::{Form, Layout};
use crate::test_batch::{ClosestHit, TestBatch};

/// A request for the closest hits of batches in a given layout. `nearest` receives one entry per
/// ray, batch by batch.
pub(super) struct Closest<'a, M> {
    pub(super) intersector: M,
    pub(super) batches: &'a [TestBatch],
    pub(super) layout: Layout,
    pub(super) nearest: &'a mut Vec<ClosestHit>,
}

/// The duration of the timed part in seconds.
pub(super) type Seconds = f64;

/// [`Closest`] in f32 or f64, with four lanes or more.
struct Run<'a, M, const DOUBLE: bool>(Closest<'a, M>);

impl<M: Intersector> Closest<'_, M> {
    /// Finds the hits in f32 or f64. Returns `None` if the layout has 16 lanes that do not fit in
    /// one register.
    pub(super) fn run<const DOUBLE: bool>(self, level: Level) -> Option<Seconds> {
        match (self.layout.lanes, self.layout.form, DOUBLE) {
            (1, Form::Packets, false) => Some(packets::<M, f32, 1>(self)),
            (1, Form::Packets, true) => Some(packets::<M, f64, 1>(self)),
            (1, Form::Blocks, false) => Some(blocks::<M, f32, 1>(self)),
            (1, Form::Blocks, true) => Some(blocks::<M, f64, 1>(self)),
            _ => level.run(Run::<M, DOUBLE>(self)),
        }
    }
}

/// Returns whether sixteen f32 values fit in one register at a level, judging by the alignment of
/// their type. If they do not, no code is generated for sixteen lanes.
pub(super) const fn one_register<S: Simd>() -> bool {
    align_of::<S::F32x16>() == 16 * size_of::<f32>()
}

impl<M: Intersector, const DOUBLE: bool> WithSimd for Run<'_, M, DOUBLE> {
    type Output = Option<Seconds>;

    #[inline(always)]
    fn run<S: Simd>(self) -> Option<Seconds> {
        let Self(work) = self;
        let Layout { form, lanes } = work.layout;
        if const { DOUBLE } {
            match (form, lanes) {
                (Form::Packets, 4) => Some(packets::<M, S::F64x4, 4>(work)),
                (Form::Packets, 8) => Some(packets::<M, S::F64x8, 8>(work)),
                (Form::Blocks, 4) => Some(blocks::<M, S::F64x4, 4>(work)),
                (Form::Blocks, 8) => Some(blocks::<M, S::F64x8, 8>(work)),
                _ => None,
            }
        } else {
            match (form, lanes) {
                (Form::Packets, 4) => Some(packets::<M, S::F32x4, 4>(work)),
                (Form::Packets, 8) => Some(packets::<M, S::F32x8, 8>(work)),
                (Form::Blocks, 4) => Some(blocks::<M, S::F32x4, 4>(work)),
                (Form::Blocks, 8) => Some(blocks::<M, S::F32x8, 8>(work)),
                _ if const { !one_register::<S>() } => None,
                (Form::Packets, _) => Some(packets::<M, S::F32x16, 16>(work)),
                (Form::Blocks, _) => Some(blocks::<M, S::F32x16, 16>(work)),
            }
        }
    }
}

/// The closest hit so far in each lane. The triangle's index is stored as a floating-point number.
#[derive(Clone, Copy)]
struct Best<L> {
    t: L,
    triangle: L,
}

impl<L: Real> Best<L> {
    #[inline(always)]
    fn new() -> Self {
        Self { t: L::of(f64::INFINITY), triangle: L::of(-1.0) }
    }

    #[inline(always)]
    fn offer(&mut self, hit: L::Mask, t: L, triangle: L) {
        let nearer = hit & t.lt(self.t);
        self.t = L::select(nearer, t, self.t);
        self.triangle = L::select(nearer, triangle, self.triangle);
    }

    /// Converts the lanes to hits one by one. Lanes beyond the last triangle contain copies of that
    /// triangle. Plain loops here and below limit the compile time, because this code is compiled
    /// for each method, layout, and level.
    #[inline(always)]
    fn lanes<const N: usize>(self, triangles: usize) -> [ClosestHit; N] {
        let zero = L::Scalar::nearest(0.0);
        let (mut t, mut number) = ([zero; N], [zero; N]);
        self.t.store(&mut t);
        self.triangle.store(&mut number);
        let mut hits = [ClosestHit::MISS; N];
        for lane in 0..N {
            let number: f64 = number[lane].into();
            if number >= 0.0 {
                let triangle = (number as u32).min(triangles as u32 - 1);
                hits[lane] = ClosestHit { t: t[lane].into(), triangle };
            }
        }
        hits
    }
}

/// Returns the total number of rays, plus `more` for each batch.
#[inline(never)]
pub(super) fn rays_of(batches: &[TestBatch], more: usize) -> usize {
    batches.iter().map(|batch| batch.rays.len() + more).sum()
}

/// Returns the total number of blocks of `lanes` triangles.
#[inline(never)]
fn blocks_of(batches: &[TestBatch], lanes: usize) -> usize {
    batches.iter().map(|batch| batch.triangles.len().div_ceil(lanes)).sum()
}

/// Returns the packets of each batch.
#[inline(never)]
pub(super) fn packets_of<const N: usize>(batches: &[TestBatch]) -> Vec<Vec<RayPacket<N>>> {
    batches.iter().map(|batch| batch.rays.chunks(N).map(RayPacket::new).collect()).collect()
}

/// Prepares the triangles of each batch. This function is compiled only once, not for each
/// instruction level.
#[inline(never)]
fn triangles_of<M: Intersector, T: Number>(
    intersector: M,
    batches: &[TestBatch],
) -> Vec<Vec<M::Triangle<T>>> {
    let mut prepared = Vec::with_capacity(batches.len());
    for batch in batches {
        let mut triangles = Vec::with_capacity(batch.triangles.len());
        for triangle in &batch.triangles {
            let [a, b, c] = triangle.0;
            triangles.push(intersector.triangle::<T>([splat(a), splat(b), splat(c)]));
        }
        prepared.push(triangles);
    }
    prepared
}

/// Copies a point to every lane.
#[inline(always)]
fn splat<L: Real>([x, y, z]: [f32; 3]) -> Vec3<L> {
    let [x, y, z] = [f64::from(x), f64::from(y), f64::from(z)];
    Vec3::splat([L::Scalar::nearest(x), L::Scalar::nearest(y), L::Scalar::nearest(z)])
}

/// Tests N rays against one triangle after another.
#[inline(always)]
fn packets<M: Intersector, L: Real, const N: usize>(work: Closest<'_, M>) -> Seconds {
    let Closest { intersector, batches, nearest, .. } = work;
    let (packets, triangles) = (packets_of::<N>(batches), triangles_of(intersector, batches));
    nearest.clear();
    nearest.reserve(rays_of(batches, N));

    let start = Instant::now();
    for (i, batch) in batches.iter().enumerate() {
        let (packets, triangles) = (&packets[i], &triangles[i]);
        let end = nearest.len() + batch.rays.len();
        for packet in packets {
            let ray =
                intersector.ray::<L>(Vec3::load_f32(&packet.origin), Vec3::load_f32(&packet.dir));
            let (mut best, mut number) = (Best::new(), L::of(0.0));
            for triangle in triangles {
                let (hit, t) = intersector.test(&M::spread::<L>(triangle), &ray);
                best.offer(hit, t, number);
                number = number + L::of(1.0);
            }
            nearest.extend_from_slice(&best.lanes::<N>(triangles.len()));
        }
        nearest.truncate(end);
    }
    start.elapsed().as_secs_f64()
}

/// Tests one ray after another against N triangles at a time.
#[inline(always)]
fn blocks<M: Intersector, L: Real, const N: usize>(work: Closest<'_, M>) -> Seconds {
    let Closest { intersector, batches, nearest, .. } = work;
    let of = |batch: &TestBatch| batch.triangles.len().div_ceil(N);
    let mut prepared: Vec<M::Triangle<L>> = Vec::with_capacity(blocks_of(batches, N));
    for batch in batches {
        for chunk in batch.triangles.chunks(N) {
            let [c1, c2, c3] = *TriangleBlock::<N>::new(chunk).corners();
            let corners = [Vec3::load_f32(&c1), Vec3::load_f32(&c2), Vec3::load_f32(&c3)];
            prepared.push(intersector.triangle::<L>(corners));
        }
    }
    nearest.clear();
    nearest.reserve(rays_of(batches, 0));
    let mut numbers = [L::Scalar::nearest(0.0); N];
    for (lane, number) in (0..).zip(&mut numbers) {
        *number = L::Scalar::nearest(f64::from(lane));
    }

    let (start, mut rest) = (Instant::now(), &prepared[..]);
    for batch in batches {
        let (blocks, others) = rest.split_at(of(batch));
        rest = others;
        for ray in &batch.rays {
            let ray = intersector.ray::<L>(splat(ray.origin), splat(ray.dir));
            let (mut best, mut number) = (Best::new(), L::load(&numbers));
            for triangles in blocks {
                let (hit, t) = intersector.test(triangles, &ray);
                best.offer(hit, t, number);
                number = number + L::of(N as f64);
            }
            let mut closest = ClosestHit::MISS;
            for hit in best.lanes::<N>(batch.triangles.len()) {
                if (hit.t, hit.triangle) < (closest.t, closest.triangle) {
                    closest = hit;
                }
            }
            nearest.push(closest);
        }
    }
    start.elapsed().as_secs_f64()
}
