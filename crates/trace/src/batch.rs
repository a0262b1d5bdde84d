//! Many rays: in chunks over the threads, each chunk behind one entry into the CPU's level.

use intertri::lanes::{Level, Simd, WithSimd};
use intertri::{Counts, Hit, Mode, Ray, Replay, Which};
#[cfg(feature = "parallel")]
use rayon::prelude::*;

use crate::answer::Answer;
use crate::bvh::Bvh;
use crate::flight;
use crate::scratch::Scratch;
use crate::screen::{RAYS, Screen, shares_origin};
use crate::tile::{self, Pencil, Tiled};
use crate::toward::{Toward, Turned};

/// Rays a thread takes at a time, at least and at most. What one tile was like tells how to begin the next.
const CHUNK: usize = 4096;
const CHUNKS: usize = 16;

/// So many rays that make no tile are answered together: more would no longer fit into the cache. Those that
/// tiles leave wait for the end of their chunk: after a tile some CPUs have a lower clock for a while.
const FLIGHT: usize = 4096;

/// Rays of the smallest tile.
const SMALLEST: usize = 16;

/// Where a tile takes more work a ray, in tests of a packet, the next have no more rays than
/// [`DENSE_RAYS`]: triangles that are small beside the tile are held against fewer windows in vain.
const DENSE: usize = 5;
const DENSE_RAYS: usize = 256;

/// Who answers rays: a hierarchy, and a mode for its leaves.
pub(crate) trait Tracer: Sync {
    type Ray: Sync;

    fn level(&self) -> Level;

    /// The hierarchy.
    fn tree(&self) -> &Bvh;

    /// Searches rays as a tile, if they share their origin; those of `next` come later.
    fn search<S: Simd, A: Answer>(
        &self,
        rays: (&[Self::Ray], &[Self::Ray]),
        room: (&mut Screen<S>, &mut Scratch),
        counts: &mut Counts,
    ) -> Tiled;

    /// Where the rays of the last tile meet what they hit.
    fn hits<S: Simd>(&self, rays: &[Self::Ray], tile: &mut Scratch, hits: &mut [Hit]);

    /// Answers the rays of those numbers, which make no tile.
    fn others<S: Simd, A: Answer>(
        &self,
        rays: &[Self::Ray],
        numbers: &[u32],
        answers: &mut [A],
        counts: &mut Counts,
    );
}

/// The answer of each ray, on all threads where there are threads.
pub(crate) fn answer<A: Answer, T: Tracer>(
    tracer: &T,
    rays: &[T::Ray],
    answers: &mut [A],
) -> Counts {
    assert_eq!(rays.len(), answers.len(), "one answer a ray");
    let each = |(rays, answers)| tracer.level().run(Batch { tracer, rays, answers });
    let add = |mut a: Counts, b: Counts| {
        a += b;
        a
    };
    #[cfg(feature = "parallel")]
    {
        // Some chunks a thread, so that all are done at about the same time.
        let even = rays.len() / (16 * rayon::current_num_threads());
        let chunk = even.next_multiple_of(CHUNK).clamp(CHUNK, CHUNKS * CHUNK);
        rays.par_chunks(chunk)
            .zip(answers.par_chunks_mut(chunk))
            .map(each)
            .reduce(Counts::default, add)
    }
    #[cfg(not(feature = "parallel"))]
    {
        let chunk = CHUNKS * CHUNK;
        let chunks = rays.chunks(chunk).zip(answers.chunks_mut(chunk));
        chunks.map(each).fold(Counts::default(), add)
    }
}

/// A hierarchy and a mode whose rays are f32.
pub(crate) struct OfMode<'a, M> {
    pub(crate) bvh: &'a Bvh,
    pub(crate) mode: &'a M,
}

impl<M: Mode> Tracer for OfMode<'_, M> {
    type Ray = Ray;

    fn level(&self) -> Level {
        self.mode.level()
    }

    fn tree(&self) -> &Bvh {
        self.bvh
    }

    #[inline(always)]
    fn search<S: Simd, A: Answer>(
        &self,
        (rays, next): (&[Ray], &[Ray]),
        room: (&mut Screen<S>, &mut Scratch),
        counts: &mut Counts,
    ) -> Tiled {
        let bvh = self.bvh;
        let Which::Certified(mode) = self.mode.which() else { return Tiled::Not };
        let (find, index) = (|place| bvh.triangle_in(place), |place| bvh.index_of(place));
        let judge = Replay { mode, rays, find, index };
        if shares_origin(rays) {
            let (by, pencil) = ((mode, &judge), Pencil { rays, next, toward: None });
            return S::vectorize(
                #[inline(always)]
                || tile::search::<S, _, _>(bvh, by, &pencil, A::ANY, room, counts),
            );
        }

        // Whether rays hit anything can be asked from where they end, too.
        let toward = if A::ANY { Toward::of(rays, self.mode.threshold()) } else { None };
        if toward.is_none() {
            return Tiled::Not;
        }
        let (by, pencil) = ((mode, &Turned(judge)), Pencil { rays, next, toward });
        S::vectorize(
            #[inline(always)]
            || tile::search::<S, _, _>(bvh, by, &pencil, A::ANY, room, counts),
        )
    }

    #[inline(always)]
    fn hits<S: Simd>(&self, rays: &[Ray], tile: &mut Scratch, hits: &mut [Hit]) {
        tile.hits::<S>(self.bvh, rays, hits);
    }

    #[inline(always)]
    fn others<S: Simd, A: Answer>(
        &self,
        rays: &[Ray],
        numbers: &[u32],
        answers: &mut [A],
        counts: &mut Counts,
    ) {
        S::vectorize(
            #[inline(always)]
            || flight::search::<M, S, A>(self.bvh, self.mode, rays, numbers, answers, counts),
        );
    }
}

/// A chunk of rays, at some level.
struct Batch<'a, T: Tracer, A> {
    tracer: &'a T,
    rays: &'a [T::Ray],
    answers: &'a mut [A],
}

impl<T: Tracer, A: Answer> WithSimd for Batch<'_, T, A> {
    type Output = Counts;

    #[inline(always)]
    fn run<S: Simd>(self) -> Counts {
        let Self { tracer, rays: all, answers: all_answers } = self;
        let (mut screen, mut scratch) = (Screen::<S>::empty(), Scratch::default());
        let mut counts = Counts::default();
        let mut others: Vec<u32> = Vec::new();
        let (mut at, mut size) = (0, RAYS);
        while at < all.len() {
            let end = (at + size).min(all.len());
            let (rays, next) = (&all[at..end], &all[end..]);

            // Rays from one origin make a tile, unless they go too far apart: then a smaller one.
            scratch.found.clear();
            let answers = &mut all_answers[at..end];
            let tile = (rays, next);
            let room = (&mut screen, &mut scratch);
            let (tiled, left, work) = match tracer.search::<S, A>(tile, room, &mut counts) {
                Tiled::Done { left, work } => {
                    S::vectorize(
                        #[inline(always)]
                        || A::of_tile::<S, T>(tracer, rays, &mut scratch, answers),
                    );
                    (true, left, work)
                }
                Tiled::TooWide if size > SMALLEST => {
                    size /= 4;
                    continue;
                }
                Tiled::TooWide | Tiled::Not => (false, u64::MAX, 0),
            };

            // The others wait for some more of them, unless some hit was asked for and is found.
            if left != 0 || screen.has_strays {
                let over = |ray: usize| A::ANY && scratch.is_hit(ray);
                let is_left = |ray: usize| left >> (ray / 16) & 1 != 0 || screen.is_stray(ray);
                let waits = |ray: &usize| is_left(*ray) && !over(*ray);
                others.extend((0..rays.len()).filter(waits).map(|ray| (at + ray) as u32));
            }

            let most = if work > DENSE * rays.len() { DENSE_RAYS } else { RAYS };
            at = end;

            // A tile may be larger again where a larger one would begin.
            while size < most && at % (4 * size) == 0 {
                size *= 4;
            }
            size = size.min(most);

            let enough = if tiled { usize::MAX } else { FLIGHT };
            if others.len() >= enough || at == all.len() && !others.is_empty() {
                tracer.others::<S, A>(all, &others, all_answers, &mut counts);
                others.clear();
            }
        }
        counts
    }
}

#[cfg(test)]
mod tests {
    use intertri::{Certified, Hit, Ray, Triangle};

    use crate::Bvh;

    /// A bumpy sheet of 30 by 30 units, of so many squares a unit.
    fn sheet(squares: usize) -> Bvh {
        let corner = |x: usize, y: usize| {
            [x as f32 / squares as f32, y as f32 / squares as f32, (x * y % 5) as f32 * 0.1]
        };
        let mut triangles = Vec::new();
        for i in 0..900 * squares * squares {
            let (x, y) = (i % (30 * squares), i / (30 * squares));
            triangles.push(Triangle([corner(x, y), corner(x + 1, y), corner(x, y + 1)]));
            triangles.push(Triangle([corner(x + 1, y + 1), corner(x + 1, y), corner(x, y + 1)]));
        }
        Bvh::new(&triangles).unwrap()
    }

    /// A picture of the sheet, and what a light sees of it: tiles are taken and change nothing.
    #[test]
    fn tiles_are_taken_and_change_nothing() {
        tiles_change_nothing(&sheet(1));
    }

    /// Some thirty triangles a ray: tiles are tried, and most rays go one by one.
    #[test]
    fn tiles_that_are_too_dense_change_nothing() {
        tiles_change_nothing(&sheet(12));
    }

    fn tiles_change_nothing(bvh: &Bvh) {
        // The direction of one ray is foreign to its tile.
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
