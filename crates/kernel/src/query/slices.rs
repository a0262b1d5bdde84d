//! Queries over slices: eight rays share each triangle, or a row of triangles a ray.

use alloc::vec::Vec;
use core::array::from_fn;

use super::rows::Rows;
use crate::filter::Filter;
use crate::intersect::{
    ClosestHit, ClosestHits, Counts, Found, LanePairs, LaneQueries, PreparedPacket, RayOnRow,
};
use crate::packet::{RayPacket, TriangleBlock};
use crate::simd::{Lanes, Mask, Simd, WithSimd, lanes_of};
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
            if rays.len() < FEW || S::F32s::N == 1 {
                for (ray, hit) in rays.iter().zip(hits) {
                    *hit = Closest { test, rows: Rows::Slice(triangles), ray }
                        .run::<S>()
                        .unwrap_or(Hit::MISS);
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

/// Tests a ray against all triangles, row by row, for hits up to `far`. Where a row may have hits, `visit` takes them
/// with the index of the row's first triangle, and returns the new `far`, or nothing to end the loop.
#[inline(always)]
fn each_row<T: LaneQueries, S: Simd>(
    test: &T,
    rows: Rows<'_>,
    ray: &Ray,
    mut visit: impl FnMut(&Found<S::F32s, S::F64s>, u32) -> Option<f32>,
) {
    let lanes = test.one_ray::<S::F32s, S::F64s>(&test.ray(ray));
    let (mut far, mut counts) = (ray.t_max, Counts::default());
    for first in (0..rows.len()).step_by(S::F32s::N) {
        let (corners, longest_edges) = rows.row::<S>(first);
        let triangles = test.triangles_of_corners::<S::F32s, S::F64s>(corners, longest_edges);
        let live = u32::MAX >> (32 - (rows.len() - first).min(S::F32s::N));
        let found = test.test(&triangles, &lanes, Lanes::splat(far), live, &mut counts);
        if let Some(found) = found
            && found.lanes() != 0
        {
            match visit(&found, first as u32) {
                Some(nearer) => far = nearer,
                None => return,
            }
        }
    }
}

/// The lanes of a row that are hits, a bit each.
#[inline(always)]
fn hits_in_row<S: Simd>(
    found: &Found<S::F32s, S::F64s>,
    t_max: f32,
    pairs: &impl LanePairs,
    enough: bool,
) -> u32 {
    let mut hits = found.exact | found.near & found.t_hi.lt(Lanes::splat(t_max)).bits();
    for lane in lanes_of(found.lanes() & !hits) {
        if enough && hits != 0 {
            break;
        }
        hits |= u32::from(pairs.meets(lane)) << lane;
    }
    hits
}

/// The closest hit of a ray.
pub(super) struct Closest<'a, T> {
    pub(super) test: T,
    pub(super) rows: Rows<'a>,
    pub(super) ray: &'a Ray,
}

impl<T: LaneQueries> WithSimd for Closest<'_, T> {
    type Output = Option<Hit>;

    #[inline(always)]
    fn run<S: Simd>(self) -> Option<Hit> {
        let Self { test, rows, ray } = self;
        let (mut closest, find) = (ClosestHit::new(ray.t_max), |place| rows.triangle(place));
        each_row::<T, S>(
            &test,
            rows,
            ray,
            #[inline(always)]
            |found, first| {
                let pairs = RayOnRow { resolver: test.resolver(), ray, first, find };
                closest.offer_row(found, first, &pairs);
                Some(closest.t_hi())
            },
        );
        test.hit(ray, &closest, find)
    }
}

/// Whether a ray hits anything.
pub(super) struct Any<'a, T> {
    pub(super) test: T,
    pub(super) rows: Rows<'a>,
    pub(super) ray: &'a Ray,
}

impl<T: LaneQueries> WithSimd for Any<'_, T> {
    type Output = bool;

    #[inline(always)]
    fn run<S: Simd>(self) -> bool {
        let Self { test, rows, ray } = self;
        let (mut any, find) = (false, |place| rows.triangle(place));
        each_row::<T, S>(
            &test,
            rows,
            ray,
            #[inline(always)]
            |found, first| {
                let pairs = RayOnRow { resolver: test.resolver(), ray, first, find };
                any = hits_in_row::<S>(found, ray.t_max, &pairs, true) != 0;
                (!any).then_some(ray.t_max)
            },
        );
        any
    }
}

/// Every hit of a ray, in the order of the triangles.
pub(super) struct All<'a, T> {
    pub(super) test: T,
    pub(super) rows: Rows<'a>,
    pub(super) ray: &'a Ray,
}

impl<T: LaneQueries> WithSimd for All<'_, T> {
    type Output = Vec<Hit>;

    #[inline(always)]
    fn run<S: Simd>(self) -> Vec<Hit> {
        let Self { test, rows, ray } = self;
        let (mut hits, find) = (Vec::new(), |place| rows.triangle(place));
        each_row::<T, S>(
            &test,
            rows,
            ray,
            #[inline(always)]
            |found, first| {
                let pairs = RayOnRow { resolver: test.resolver(), ray, first, find };
                for lane in lanes_of(hits_in_row::<S>(found, ray.t_max, &pairs, false)) {
                    let (triangle, index) = (pairs.triangle(lane), first + lane as u32);
                    hits.push(test.resolver().hit_attributes(ray, &triangle, index, (0, index)));
                }
                Some(ray.t_max)
            },
        );
        hits
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::simd::Level;
    use crate::{Certified, Double, Exact, Mode, Threshold};

    /// A level of one lane a register, as WebAssembly without simd128 has it.
    #[derive(Clone, Copy)]
    struct OneLane<S>(S);

    impl<S: Simd> Simd for OneLane<S> {
        type F32x4 = S::F32x4;
        type F32x8 = S::F32x8;
        type F32x16 = S::F32x16;
        type F64x4 = S::F64x4;
        type F64x8 = S::F64x8;
        type I64x4 = S::I64x4;
        type I64x8 = S::I64x8;
        type F32s = f32;
        type F64s = f64;
        const LEVEL: Level = S::LEVEL;
    }

    /// The closest hit, whether there is one, and all.
    struct ByOneLane<'a, T>(T, &'a [Triangle], &'a Ray);

    impl<T: LaneQueries> WithSimd for ByOneLane<'_, T> {
        type Output = (Option<Hit>, bool, usize);

        #[inline(always)]
        fn run<S: Simd>(self) -> Self::Output {
            let Self(test, triangles, ray) = self;
            let rows = Rows::Slice(triangles);
            let closest = Closest { test, rows, ray }.run::<OneLane<S>>();
            let any = Any { test, rows, ray }.run::<OneLane<S>>();
            (closest, any, All { test, rows, ray }.run::<OneLane<S>>().len())
        }
    }

    /// Small whole numbers, so that rays often meet edges, corners and planes exactly.
    fn number(state: &mut u64) -> f32 {
        *state = state.wrapping_mul(0x5851_f42d_4c95_7f2d).wrapping_add(0x1405_7b7e_f767_814f);
        ((*state >> 33) % 9) as f32 - 4.0
    }

    fn check<M: Mode>(mode: &M, triangles: &[Triangle], ray: &Ray) -> bool {
        let want = mode.closest(triangles, ray);
        let all = mode.all(triangles, ray).len();
        for level in Level::all() {
            let found = level.run(ByOneLane(mode.test(), triangles, ray));
            assert_eq!(found, (want, want.is_some(), all), "{triangles:?} {ray:?}");
        }
        want.is_some()
    }

    #[test]
    fn one_lane_answers_as_many_do() {
        let (state, mut hits) = (&mut 7, 0);
        for turn in 0..3000 {
            let mut point = || {
                let scale = if turn % 2 == 0 { 1.0 } else { 1.1 };
                [0, 1, 2].map(|_| scale * number(state))
            };
            let triangles: Vec<_> =
                (0..turn % 37).map(|_| Triangle([point(), point(), point()])).collect();
            let ray = Ray::new(point(), point()).between(0.0, 0.5 * (turn % 16) as f32);
            hits += usize::from(check(&Exact::default(), &triangles, &ray));
            check(&Certified::new(Threshold::ZERO), &triangles, &ray);
            check(&Double::default(), &triangles, &ray);
        }
        assert!(hits > 500, "{hits}");
    }
}
