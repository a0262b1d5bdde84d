//! Many rays: in chunks over the threads, each chunk behind one entry into the CPU's level.

use intertri::lanes::{Simd, WithSimd};
use intertri::{Counts, Hit, Mode, Ray};
#[cfg(feature = "parallel")]
use rayon::prelude::*;

use crate::bvh::Bvh;
use crate::{search, tile};

/// Rays a thread takes at a time.
const CHUNK: usize = 1024;

/// The closest hit of each ray.
pub(crate) fn closest<M: Mode>(bvh: &Bvh, mode: &M, rays: &[Ray], hits: &mut [Hit]) -> Counts {
    assert_eq!(rays.len(), hits.len(), "one hit a ray");
    chunks(rays, hits, |rays, hits| mode.level().run(Closest { bvh, mode, rays, hits }))
}

/// Whether each ray hits anything.
pub(crate) fn any<M: Mode>(bvh: &Bvh, mode: &M, rays: &[Ray], hits: &mut [bool]) -> Counts {
    assert_eq!(rays.len(), hits.len(), "one answer a ray");
    chunks(rays, hits, |rays, hits| mode.level().run(Any { bvh, mode, rays, hits }))
}

/// Does chunk by chunk, on all threads where there are threads, and adds up the counts.
pub(crate) fn chunks<R: Sync, T: Send>(
    rays: &[R],
    answers: &mut [T],
    each: impl Fn(&[R], &mut [T]) -> Counts + Sync,
) -> Counts {
    let add = |mut a: Counts, b: Counts| {
        a += b;
        a
    };
    #[cfg(feature = "parallel")]
    return rays
        .par_chunks(CHUNK)
        .zip(answers.par_chunks_mut(CHUNK))
        .map(|(rays, answers)| each(rays, answers))
        .reduce(Counts::default, add);
    #[cfg(not(feature = "parallel"))]
    return rays
        .chunks(CHUNK)
        .zip(answers.chunks_mut(CHUNK))
        .map(|(rays, answers)| each(rays, answers))
        .fold(Counts::default(), add);
}

struct Closest<'a, M> {
    bvh: &'a Bvh,
    mode: &'a M,
    rays: &'a [Ray],
    hits: &'a mut [Hit],
}

impl<M: Mode> WithSimd for Closest<'_, M> {
    type Output = Counts;

    #[inline(always)]
    fn run<S: Simd>(self) -> Counts {
        let Self { bvh, mode, rays, hits } = self;
        let (mut stack, mut counts) = (bvh.stack(), Counts::default());
        let mut scratch = tile::Scratch::default();
        for (rays, hits) in rays.chunks(tile::RAYS).zip(hits.chunks_mut(tile::RAYS)) {
            if let Some(mode) = mode.certified()
                && tile::shares_origin(rays)
                && tile::closest::<S>(bvh, mode, rays, false, &mut scratch, &mut counts)
            {
                tile::hits::<S>(bvh, rays, &mut scratch, hits);
                continue;
            }
            for (ray, hit) in rays.iter().zip(hits) {
                let best = search::closest::<M, S>(bvh, mode, ray, false, &mut stack, &mut counts);
                *hit = bvh.hit(mode, ray, &best);
            }
        }
        counts
    }
}

struct Any<'a, M> {
    bvh: &'a Bvh,
    mode: &'a M,
    rays: &'a [Ray],
    hits: &'a mut [bool],
}

impl<M: Mode> WithSimd for Any<'_, M> {
    type Output = Counts;

    #[inline(always)]
    fn run<S: Simd>(self) -> Counts {
        let Self { bvh, mode, rays, hits } = self;
        let (mut stack, mut counts) = (bvh.stack(), Counts::default());
        let mut scratch = tile::Scratch::default();
        for (rays, hits) in rays.chunks(tile::RAYS).zip(hits.chunks_mut(tile::RAYS)) {
            if let Some(mode) = mode.certified()
                && tile::shares_origin(rays)
                && tile::closest::<S>(bvh, mode, rays, true, &mut scratch, &mut counts)
            {
                for (hit, found) in hits.iter_mut().zip(&scratch.found) {
                    *hit = found.is_some();
                }
                continue;
            }
            for (ray, hit) in rays.iter().zip(hits) {
                let best = search::closest::<M, S>(bvh, mode, ray, true, &mut stack, &mut counts);
                *hit = best.is_hit();
            }
        }
        counts
    }
}
