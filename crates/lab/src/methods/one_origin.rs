//! The modes `certified` and `exact` for rays that share an origin, as camera rays and hard shadow rays do.
//! Coefficients belong to a triangle and the origin, and a ray costs three products.
//!
//! The coefficients are computed before the clock starts, like all constants of a triangle: the rays of
//! a picture share them.

use std::time::Instant;

use intertri::internal::{Filter, SharedOriginBlock, Test};
use intertri::simd::{Lane, Simd, Width, WithSimd};
use intertri::{ClosestHits, Counts, LaneQueries, Ray, RayPacket, Triangle, TriangleBlock};

use super::closest::{Seconds, one_register, packets_of, rays_of};
use super::kernel::answers;
use crate::layout::{Form, Layout};
use crate::test_batch::{Answer, ClosestHit, TestBatch};

/// Pairs: a ray shares its origin with itself.
pub(super) fn pairs(filter: Filter<'_>, triangles: &[Triangle], rays: &[Ray], to: &mut [Answer]) {
    filter.level().run(Pairs { filter, triangles, rays, to });
}

/// The closest hits of batches; `None` but for packets of rays that share their batch's origin.
pub(super) fn closest(
    filter: Filter<'_>,
    batches: &[TestBatch],
    layout: Layout,
    nearest: &mut Vec<ClosestHit>,
) -> Option<Seconds> {
    let bits = |ray: &Ray| ray.origin.map(f32::to_bits);
    let shared =
        |batch: &TestBatch| batch.rays.windows(2).all(|two| bits(&two[0]) == bits(&two[1]));
    let has = layout.form == Form::Packets && layout.lanes > 1 && batches.iter().all(shared);
    let work = Closest { filter, batches, lanes: layout.lanes, nearest };
    if has { filter.level().run(work) } else { None }
}

struct Pairs<'a> {
    filter: Filter<'a>,
    triangles: &'a [Triangle],
    rays: &'a [Ray],
    to: &'a mut [Answer],
}

impl WithSimd for Pairs<'_> {
    type Output = ();

    #[inline(always)]
    fn run<S: Simd>(self) {
        let Self { filter, triangles, rays, to } = self;
        for ((triangle, ray), to) in triangles.iter().zip(rays).zip(to) {
            let packet = RayPacket::<4>::new(&[Ray::new(ray.origin, ray.dir)]);
            let block = TriangleBlock::new(std::slice::from_ref(triangle));
            let seen = filter.shared_origin_in::<S>(&block, ray.origin);
            let lanes = filter.prepare_packet_in::<S, 4>(&packet);
            let (find, mut closest) = (|_| *triangle, ClosestHits::new(&packet.t_max));
            let (live, counts) = (packet.live(), &mut Counts::default());
            filter.shared_origin_closest_in(&lanes, &[seen], 0, find, live, &mut closest, counts);
            let found = filter.hit(&packet.ray(0), &closest.lane(0), find);
            *to = found.map_or(Answer::default(), |hit| Answer { hit: true, t: hit.t });
        }
    }
}

struct Closest<'a> {
    filter: Filter<'a>,
    batches: &'a [TestBatch],
    lanes: usize,
    nearest: &'a mut Vec<ClosestHit>,
}

impl WithSimd for Closest<'_> {
    type Output = Option<Seconds>;

    #[inline(always)]
    fn run<S: Simd>(self) -> Option<Seconds> {
        let Self { filter, batches, lanes, nearest } = self;
        nearest.clear();
        nearest.reserve(rays_of(batches, 0));
        match lanes {
            4 => Some(packets::<S, 4>(filter, batches, nearest)),
            8 => Some(packets::<S, 8>(filter, batches, nearest)),
            _ if const { one_register::<S>() } => Some(packets::<S, 16>(filter, batches, nearest)),
            _ => None,
        }
    }
}

/// N rays of one origin against one triangle after another.
#[inline(always)]
fn packets<S: Simd, const N: usize>(
    filter: Filter<'_>,
    batches: &[TestBatch],
    nearest: &mut Vec<ClosestHit>,
) -> Seconds
where
    Lane<N>: Width,
{
    let (packets, blocks) = (packets_of::<N>(batches), blocks_of::<S>(filter, batches));
    let mut counts = Counts::default();

    let start = Instant::now();
    for (i, batch) in batches.iter().enumerate() {
        let (packets, seen) = (&packets[i], &blocks[i]);
        let find = |place: u32| batch.triangles[place as usize];
        for packet in packets {
            let rays = filter.prepare_packet_in::<S, N>(packet);
            let (live, mut closest) = (packet.live(), ClosestHits::new(&packet.t_max));
            let counts = &mut counts;
            filter.shared_origin_closest_in(&rays, seen, 0, find, live, &mut closest, counts);
            answers::<Filter<'_>, S, N>(&filter, &rays, &closest, find, live, nearest);
        }
    }
    start.elapsed().as_secs_f64()
}

/// The triangles of each batch as seen from its origin.
fn blocks_of<S: Simd>(filter: Filter<'_>, batches: &[TestBatch]) -> Vec<Vec<SharedOriginBlock>> {
    let seen = |batch: &TestBatch| {
        let origin = batch.rays.first().map_or([0.0; 3], |ray| ray.origin);
        let blocks = batch.triangles.chunks(8).map(TriangleBlock::new);
        blocks.map(|block| filter.shared_origin_in::<S>(&block, origin)).collect()
    };
    batches.iter().map(seen).collect()
}
