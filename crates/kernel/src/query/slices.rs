//! Queries over slices: eight rays share each triangle, or eight triangles a ray.

use alloc::vec::Vec;
use core::array::from_fn;

use crate::filter::Filter;
use crate::intersect::{ClosestHit, ClosestHits, Counts, LaneQueries, PreparedPacket};
use crate::packet::{RayPacket, TriangleBlock};
use crate::simd::{Simd, WithSimd, lanes_of};
use crate::{Hit, Ray, Triangle};

/// From this many rays on, eight rays share each triangle.
const FEW: usize = 4;

/// So many packets of eight rays share what is computed from a triangle.
const PACKETS: usize = 8;

/// So many rays from one origin are worth a look at the triangles from there.
const SHARED: usize = 8 * PACKETS;

/// So many triangles are prepared at a time.
const PREPARED: usize = 16;

/// Whether there are many rays, all from one origin.
pub(super) fn shares_origin(rays: &[Ray]) -> bool {
    let bits = |ray: &Ray| ray.origin.map(f32::to_bits);
    rays.len() >= SHARED && rays.iter().all(|ray| bits(ray) == bits(&rays[0]))
}

/// The closest hit of each of many rays.
pub(super) struct ClosestBatch<'a, T> {
    pub(super) test: T,
    pub(super) triangles: &'a [Triangle],
    pub(super) rays: &'a [Ray],
    pub(super) hits: &'a mut [Hit],
}

impl<T: LaneQueries> WithSimd for ClosestBatch<'_, T> {
    type Output = ();

    #[inline(always)]
    fn run<S: Simd>(self) {
        let Self { test, triangles, rays, hits } = self;
        let find = |place: u32| triangles[place as usize];
        for (rays, hits) in rays.chunks(8 * PACKETS).zip(hits.chunks_mut(8 * PACKETS)) {
            if rays.len() < FEW {
                for (ray, hit) in rays.iter().zip(hits) {
                    let mut closest = ClosestHit::new(ray.t_max);
                    one_ray::<T, S>(&test, triangles, ray, &mut closest);
                    *hit = test.hit(ray, &closest, find).unwrap_or(Hit::MISS);
                }
                continue;
            }
            let packets = Packets::new(rays);
            let prepared = packets.prepare::<T, S>(&test);
            let mut closest = packets.closest::<S>();
            for (some, first) in triangles.chunks(PREPARED).zip((0..).step_by(PREPARED)) {
                let last = some.len() - 1;
                let some_prepared: [_; PREPARED] = from_fn(|i| test.prepare(&some[i.min(last)]));
                let (some, counts) = (&some_prepared[..some.len()], &mut Counts::default());
                for p in 0..packets.used {
                    let (rays, live) = (&prepared[p], packets.all[p].live());
                    let closest = &mut closest[p];
                    test.packet_closest_of_in(rays, some, first, find, live, closest, counts);
                }
            }
            write::<T, S>(&test, find, &closest, (rays, hits));
        }
    }
}

/// The closest hit of each of many rays that share their origin (document D).
pub(super) struct SharedOriginBatch<'a> {
    pub(super) test: Filter<'a>,
    pub(super) triangles: &'a [Triangle],
    pub(super) rays: &'a [Ray],
    pub(super) hits: &'a mut [Hit],
}

impl WithSimd for SharedOriginBatch<'_> {
    type Output = ();

    #[inline(always)]
    fn run<S: Simd>(self) {
        let Self { test, triangles, rays, hits } = self;
        let find = |place: u32| triangles[place as usize];
        for (rays, hits) in rays.chunks(8 * PACKETS).zip(hits.chunks_mut(8 * PACKETS)) {
            let packets = Packets::new(rays);
            let prepared = packets.prepare::<Filter<'_>, S>(&test);
            let mut closest = packets.closest::<S>();
            for (eight, first) in triangles.chunks(8).zip((0..).step_by(8)) {
                let seen =
                    test.shared_origin_in::<S>(&TriangleBlock::new_in::<S>(eight), rays[0].origin);
                let (seen, counts) = (core::slice::from_ref(&seen), &mut Counts::default());
                for p in 0..packets.used {
                    let (rays, live) = (&prepared[p], packets.all[p].live());
                    let closest = &mut closest[p];
                    test.shared_origin_closest_in(rays, seen, first, find, live, closest, counts);
                }
            }
            write::<Filter<'_>, S>(&test, find, &closest, (rays, hits));
        }
    }
}

/// Some rays as packets of eight.
struct Packets {
    all: [RayPacket<8>; PACKETS],
    used: usize,
}

impl Packets {
    #[inline(always)]
    fn new(rays: &[Ray]) -> Self {
        let all = from_fn(|p| RayPacket::new(rays.get(8 * p..).unwrap_or(&[])));
        Self { all, used: rays.len().div_ceil(8) }
    }

    #[inline(always)]
    fn prepare<T: LaneQueries, S: Simd>(&self, test: &T) -> [PreparedPacket<'_, T, S, 8>; PACKETS] {
        self.all.each_ref().map(
            #[inline(always)]
            |packet| test.prepare_packet_in::<S, 8>(packet),
        )
    }

    #[inline(always)]
    fn closest<S: Simd>(&self) -> [ClosestHits<S::F32x8, 8>; PACKETS] {
        self.all.each_ref().map(
            #[inline(always)]
            |packet| ClosestHits::new(&packet.t_max),
        )
    }
}

/// Writes the hits of the rays.
#[inline(always)]
fn write<T: LaneQueries, S: Simd>(
    test: &T,
    find: impl Fn(u32) -> Triangle + Copy,
    closest: &[ClosestHits<S::F32x8, 8>; PACKETS],
    (rays, hits): (&[Ray], &mut [Hit]),
) {
    for (i, (ray, hit)) in rays.iter().zip(hits).enumerate() {
        let closest = closest[i / 8].lane(i % 8);
        *hit = test.hit(ray, &closest, find).unwrap_or(Hit::MISS);
    }
}

/// One ray against all triangles, eight at a time.
#[inline(always)]
fn one_ray<T: LaneQueries, S: Simd>(
    test: &T,
    triangles: &[Triangle],
    ray: &Ray,
    closest: &mut ClosestHit,
) {
    let find = |place: u32| triangles[place as usize];
    let prepared = test.prepare_ray(ray);
    for (k, chunk) in (0..).zip(triangles.chunks(8)) {
        let indices = from_fn(|i| 8 * k + i as u32);
        let block = TriangleBlock::new(chunk);
        let counts = &mut Counts::default();
        test.closest_in::<S>(&prepared, &block, &indices, 8 * k, find, closest, counts);
    }
}

/// Whether a ray hits anything.
pub(super) struct Any<'a, T> {
    pub(super) test: T,
    pub(super) triangles: &'a [Triangle],
    pub(super) ray: &'a Ray,
}

impl<T: LaneQueries> WithSimd for Any<'_, T> {
    type Output = bool;

    #[inline(always)]
    fn run<S: Simd>(self) -> bool {
        let Self { test, triangles, ray } = self;
        let mut closest = ClosestHit::new(ray.t_max);
        for chunk in triangles.chunks(8) {
            one_ray::<T, S>(&test, chunk, ray, &mut closest);
            if closest.is_hit() {
                return true;
            }
        }
        false
    }
}

/// Every hit of a ray, in the order of the triangles.
pub(super) struct All<'a, T> {
    pub(super) test: T,
    pub(super) triangles: &'a [Triangle],
    pub(super) ray: &'a Ray,
}

impl<T: LaneQueries> WithSimd for All<'_, T> {
    type Output = Vec<Hit>;

    #[inline(always)]
    fn run<S: Simd>(self) -> Vec<Hit> {
        let Self { test, triangles, ray } = self;
        let mut hits = Vec::new();
        for (chunk, first) in triangles.chunks(8).zip((0..).step_by(8)) {
            let block = TriangleBlock::<8>::new(chunk);
            let found = test.block_in::<S, 8>(ray, &block, &mut Counts::default());
            for lane in lanes_of(found.bits) {
                let (triangle, index) = (&chunk[lane], first + lane as u32);
                hits.push(test.resolver().hit_attributes(ray, triangle, index, (0, index)));
            }
        }
        hits
    }
}
