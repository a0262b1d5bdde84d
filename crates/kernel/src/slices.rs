//! The verbs over slices of any length: eight rays share each triangle, or eight triangles a ray.

use core::array::from_fn;

use crate::lanes::{Simd, WithSimd};
use crate::mode::{Counts, Test, lanes_of};
use crate::{Best, Bests, Hit, Mode, Ray, RayPacket, Triangle, TrianglePack};

/// From this many rays on, eight rays share each triangle.
const FEW: usize = 4;

/// So many packets of eight rays share what is computed from a triangle.
const PACKETS: usize = 8;

/// So many triangles are prepared at a time.
const PREPARED: usize = 16;

/// The closest hit of each of many rays.
pub(crate) struct ClosestOfEach<'a, M> {
    pub(crate) mode: &'a M,
    pub(crate) triangles: &'a [Triangle],
    pub(crate) rays: &'a [Ray],
    pub(crate) hits: &'a mut [Hit],
}

impl<M: Test> WithSimd for ClosestOfEach<'_, M> {
    type Output = ();

    #[inline(always)]
    fn run<S: Simd>(self) {
        let Self { mode, triangles, rays, hits } = self;
        let find = |place: u32| triangles[place as usize];
        for (rays, hits) in rays.chunks(8 * PACKETS).zip(hits.chunks_mut(8 * PACKETS)) {
            if rays.len() < FEW {
                for (ray, hit) in rays.iter().zip(hits) {
                    let mut best = Best::new(ray.t_max);
                    one_ray::<M, S>(mode, triangles, ray, &mut best);
                    *hit = mode.hit(ray, &best, find);
                }
            } else {
                let packets: [RayPacket<8>; PACKETS] =
                    from_fn(|p| RayPacket::new(rays.get(8 * p..).unwrap_or(&[])));
                let prepared =
                    packets.each_ref().map(|packet| mode.prepare_packet_in::<S, 8>(packet));
                let mut bests = packets.each_ref().map(|p| Bests::<S::F32x8, 8>::new(&p.t_max));
                let used = rays.len().div_ceil(8);
                for (block, first) in triangles.chunks(PREPARED).zip((0..).step_by(PREPARED)) {
                    let last = block.len() - 1;
                    let prepared_triangles: [_; PREPARED] =
                        from_fn(|i| mode.prepare(&block[i.min(last)]));
                    for p in 0..used {
                        mode.packet_closest_of_in(
                            &prepared[p],
                            &prepared_triangles[..block.len()],
                            first,
                            find,
                            packets[p].live(),
                            &mut bests[p],
                            &mut Counts::default(),
                        );
                    }
                }
                for (i, (ray, hit)) in rays.iter().zip(hits).enumerate() {
                    *hit = mode.hit(ray, &bests[i / 8].lane(i % 8), find);
                }
            }
        }
    }
}

/// One ray against all triangles, eight at a time.
#[inline(always)]
fn one_ray<M: Test, S: Simd>(mode: &M, triangles: &[Triangle], ray: &Ray, best: &mut Best) {
    let find = |place: u32| triangles[place as usize];
    let prepared = mode.prepare_ray(ray);
    for (k, chunk) in (0..).zip(triangles.chunks(8)) {
        let indices = from_fn(|i| 8 * k + i as u32);
        let pack = TrianglePack::new(chunk);
        let counts = &mut Counts::default();
        mode.closest_in::<S>(&prepared, &pack, &indices, 8 * k, find, best, counts);
    }
}

/// Whether a ray hits anything.
pub(crate) struct Any<'a, M> {
    pub(crate) mode: &'a M,
    pub(crate) triangles: &'a [Triangle],
    pub(crate) ray: &'a Ray,
}

impl<M: Test> WithSimd for Any<'_, M> {
    type Output = bool;

    #[inline(always)]
    fn run<S: Simd>(self) -> bool {
        let Self { mode, triangles, ray } = self;
        triangles.chunks(8).any(|chunk| {
            let mut best = Best::new(ray.t_max);
            one_ray::<M, S>(mode, chunk, ray, &mut best);
            best.is_hit()
        })
    }
}

/// Every hit of a ray.
pub(crate) struct All<'a, M, E> {
    pub(crate) mode: &'a M,
    pub(crate) triangles: &'a [Triangle],
    pub(crate) ray: &'a Ray,
    pub(crate) each: E,
}

impl<M: Test, E: FnMut(Hit)> WithSimd for All<'_, M, E> {
    type Output = ();

    #[inline(always)]
    fn run<S: Simd>(self) {
        let Self { mode, triangles, ray, mut each } = self;
        for (k, chunk) in triangles.chunks(8).enumerate() {
            let pack = TrianglePack::<8>::new(chunk);
            let hits = mode.pack_in::<S, 8>(ray, &pack, &mut Counts::default());
            for lane in lanes_of(hits.bits) {
                each(Hit::at(hits.t[lane], (8 * k + lane) as u32, ray, &chunk[lane]));
            }
        }
    }
}
