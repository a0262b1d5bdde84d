//! Many rays: in chunks over the threads, each chunk behind one entry into the CPU's level.

use intertri::lanes::{Simd, WithSimd};
use intertri::{Counts, Hit, Mode, Ray};
#[cfg(feature = "parallel")]
use rayon::prelude::*;

use crate::answer::Answer;
use crate::bvh::Bvh;
use crate::flight;
use crate::scratch::Scratch;
use crate::screen::{RAYS, shares_origin};
use crate::tile;

/// Rays a thread takes at a time.
const CHUNK: usize = 4096;

/// Rays of the smallest tile.
const SMALLEST: usize = 16;

/// The closest hit of each ray.
pub(crate) fn closest<M: Mode>(bvh: &Bvh, mode: &M, rays: &[Ray], hits: &mut [Hit]) -> Counts {
    assert_eq!(rays.len(), hits.len(), "one hit a ray");
    chunks(rays, hits, |rays, hits| mode.level().run(Batch { bvh, mode, rays, answers: hits }))
}

/// The index of the closest triangle of each ray.
pub(crate) fn triangles<M: Mode>(
    bvh: &Bvh,
    mode: &M,
    rays: &[Ray],
    triangles: &mut [u32],
) -> Counts {
    assert_eq!(rays.len(), triangles.len(), "one answer a ray");
    chunks(rays, triangles, |rays, answers| mode.level().run(Batch { bvh, mode, rays, answers }))
}

/// Whether each ray hits anything.
pub(crate) fn any<M: Mode>(bvh: &Bvh, mode: &M, rays: &[Ray], hits: &mut [bool]) -> Counts {
    assert_eq!(rays.len(), hits.len(), "one answer a ray");
    chunks(rays, hits, |rays, hits| mode.level().run(Batch { bvh, mode, rays, answers: hits }))
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

/// A chunk of rays, at some level.
struct Batch<'a, M, A> {
    bvh: &'a Bvh,
    mode: &'a M,
    rays: &'a [Ray],
    answers: &'a mut [A],
}

impl<M: Mode, A: Answer> WithSimd for Batch<'_, M, A> {
    type Output = Counts;

    #[inline(always)]
    fn run<S: Simd>(self) -> Counts {
        let Self { bvh, mode, rays: all, answers } = self;
        let (mut scratch, mut counts) = (Scratch::default(), Counts::default());
        let mut flying: Vec<u32> = Vec::new();
        let (mut at, mut size) = (0, RAYS);
        while at < all.len() {
            let end = (at + size).min(all.len());
            let (rays, next) = (&all[at..end], &all[end..]);

            // Rays from one origin make a tile, unless they go too far apart: then a smaller one. Bit p
            // of `left` is set where the tile leaves its packet p.
            let mut left = u32::MAX;
            if let Some(mode) = mode.certified()
                && shares_origin::<S>(rays)
            {
                let (rays, answers) = ((rays, next), &mut answers[at..end]);
                let (scratch, counts) = (&mut scratch, &mut counts);
                match tile::search::<S, A>(bvh, mode, rays, answers, A::ANY, scratch, counts) {
                    Some(packets) => {
                        A::of_tile::<S>(bvh, rays.0, scratch, answers);
                        left = packets;
                    }
                    None if size > SMALLEST => {
                        size /= 4;
                        continue;
                    }
                    None => scratch.found.clear(),
                }
            } else {
                scratch.found.clear();
            }

            // The others fly, unless some hit was asked for and is found.
            if left != 0 {
                let over = |ray: usize| A::ANY && scratch.is_hit(ray);
                let flies = |ray: &usize| left >> (ray / 16) & 1 != 0 && !over(*ray);
                flying.extend((0..rays.len()).filter(flies).map(|ray| (at + ray) as u32));
            }
            (at, size) = (end, if end % RAYS == 0 { RAYS } else { size });
        }
        if !flying.is_empty() {
            flight::search::<M, S, A>(bvh, mode, all, &flying, answers, &mut counts);
        }
        counts
    }
}

#[cfg(test)]
mod tests {
    use intertri::{Certified, Hit, Ray, Triangle};

    use crate::Bvh;

    /// A picture of a bumpy sheet, and what a light sees of it: tiles are taken and change nothing.
    #[test]
    fn tiles_are_taken_and_change_nothing() {
        let corner = |x: usize, y: usize| [x as f32, y as f32, (x * y % 5) as f32 * 0.1];
        let mut triangles = Vec::new();
        for i in 0..900 {
            let (x, y) = (i % 30, i / 30);
            triangles.push(Triangle([corner(x, y), corner(x + 1, y), corner(x, y + 1)]));
            triangles.push(Triangle([corner(x + 1, y + 1), corner(x + 1, y), corner(x, y + 1)]));
        }
        let bvh = Bvh::new(&triangles).unwrap();

        // Sixteen tiles; the direction of one ray is foreign to its tile.
        let ray = |i: usize| {
            let (tile, i) = (i / 256, i % 256);
            let at = |k: usize| (k as f32 - 28.0) / 40.0;
            let dir = [at(tile % 4 * 16 + i % 16), at(tile / 4 * 16 + i / 16), -1.0];
            Ray::new([14.3, 15.1, 25.0], dir)
        };
        let mut rays: Vec<Ray> = (0..4096).map(ray).collect();
        rays[700].dir = [0.0, 1.0, 0.2];

        let mode = Certified::default();
        let (mut hits, mut any) = (vec![Hit::MISS; rays.len()], vec![false; rays.len()]);
        bvh.closest_of_each(&mode, &rays, &mut hits);
        bvh.any_of_each(&mode, &rays, &mut any);
        for ((ray, hit), any) in rays.iter().zip(&hits).zip(&any) {
            assert_eq!(*hit, bvh.closest(&mode, ray));
            assert_eq!(*any, hit.is_hit());
        }
        assert!(hits.iter().filter(|hit| hit.is_hit()).count() > 2000);

        // In another order the same rays have little in common.
        let mixed: Vec<Ray> = (0..4096).map(|i| rays[i * 1021 % 4096]).collect();
        let tiled = hits.clone();
        bvh.closest_of_each(&mode, &mixed, &mut hits);
        for (i, hit) in hits.iter().enumerate() {
            assert_eq!(*hit, tiled[i * 1021 % 4096]);
        }
    }
}
