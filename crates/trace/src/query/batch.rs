//! Many rays: in chunks over the threads, each chunk behind one entry into the CPU's level.

use intertri::internal::{Filter, Lanes64, Test, Which};
use intertri::simd::{Simd, WithSimd};
use intertri::{Counts, Hit, LaneQueries, Ray, fixed};
#[cfg(feature = "parallel")]
use rayon::prelude::*;

use crate::answers::Answers;
use crate::bundle::{
    Bundle, BundleRays, CommonEnd, Outcome, Projection, RAYS, Results, Room, shares_origin,
};
use crate::single::{Closest, Kept};
use crate::stream::Stream;
use crate::tree::Bvh;

/// Rays a thread takes at a time, at least and at most. What one bundle was like tells how to begin the
/// next.
const CHUNK: usize = 4096;
const CHUNKS: usize = 16;

/// So many rays that make no bundle are a stream: more would no longer fit into the cache. Those that
/// bundles leave wait for the end of their chunk: after a bundle some CPUs have a lower clock for a while.
const STREAM: usize = 4096;

/// Rays of the smallest bundle.
const SMALLEST: usize = 16;

/// Where a bundle takes more work a ray, in tests of a packet, the next have no more rays than
/// [`BUSY_RAYS`]: triangles that are small beside the bundle are held against fewer windows in vain.
const BUSY: usize = 5;
const BUSY_RAYS: usize = 256;

/// The answer of each ray, on all threads where there are threads.
pub(super) fn answer(bvh: &Bvh, which: Which, rays: &[Ray], answers: Answers<'_>) -> Counts {
    match which {
        Which::Filter(test) => by_filter(bvh, test, rays, answers),
        Which::Lanes64(test) => by_lanes64(bvh, test, rays, answers),
    }
}

/// By the filter: coherent rays in bundles, the others in streams.
fn by_filter(bvh: &Bvh, test: Filter, rays: &[Ray], answers: Answers<'_>) -> Counts {
    in_chunks(rays, answers, |rays, answers| chunk(bvh, test, (rays, &[]), answers))
}

/// A chunk of rays on this thread. Of a grid, `on_grid` are the rays as their caller has them.
pub(super) fn chunk(
    bvh: &Bvh,
    test: Filter,
    (rays, on_grid): (&[Ray], &[fixed::Ray]),
    answers: Answers<'_>,
) -> Counts {
    test.level().run(Chunk { bvh, test, rays, on_grid, answers })
}

/// In f64 lanes: a ray a call, for this is only there to compare with.
fn by_lanes64(bvh: &Bvh, test: Lanes64, rays: &[Ray], answers: Answers<'_>) -> Counts {
    in_chunks(rays, answers, |rays, mut answers| {
        let mut counts = Counts::default();
        let kept = &mut *Kept::lend(bvh);
        for (number, ray) in rays.iter().enumerate() {
            let counts = &mut counts;
            let closest = if answers.any() {
                test.level().run(Closest::<_, true> { bvh, test, ray, kept, counts })
            } else {
                test.level().run(Closest::<_, false> { bvh, test, ray, kept, counts })
            };
            if !answers.write(number, &closest) {
                let hit = test.hit(ray, &closest, |place| bvh.triangle_in(place));
                answers.write_hit(number, hit.unwrap_or(Hit::MISS));
            }
        }
        counts
    })
}

/// Hands chunks of rays and their answers to all threads.
fn in_chunks(
    rays: &[Ray],
    answers: Answers<'_>,
    each: impl Fn(&[Ray], Answers<'_>) -> Counts + Sync,
) -> Counts {
    match answers {
        Answers::Hits(hits) => chunks(rays, hits, |rays, hits| each(rays, Answers::Hits(hits))),
        Answers::Triangles(triangles) => {
            chunks(rays, triangles, |rays, some| each(rays, Answers::Triangles(some)))
        }
        Answers::Any(any) => chunks(rays, any, |rays, any| each(rays, Answers::Any(any))),
    }
}

/// The same of one kind of answer, and of rays of any kind.
pub(crate) fn chunks<R: Sync, A: Send>(
    rays: &[R],
    answers: &mut [A],
    each: impl Fn(&[R], &mut [A]) -> Counts + Sync,
) -> Counts {
    assert_eq!(rays.len(), answers.len(), "one answer a ray");
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
            .map(|(rays, answers)| each(rays, answers))
            .reduce(Counts::default, add)
    }
    #[cfg(not(feature = "parallel"))]
    {
        let chunk = CHUNKS * CHUNK;
        let chunks = rays.chunks(chunk).zip(answers.chunks_mut(chunk));
        chunks.map(|(rays, answers)| each(rays, answers)).fold(Counts::default(), add)
    }
}

/// A chunk of rays.
struct Chunk<'a, 'b> {
    bvh: &'a Bvh,
    test: Filter,
    rays: &'a [Ray],
    on_grid: &'a [fixed::Ray],
    answers: Answers<'b>,
}

impl WithSimd for Chunk<'_, '_> {
    type Output = Counts;

    #[inline(always)]
    fn run<S: Simd>(self) -> Counts {
        let Self { bvh, test, rays: all, on_grid, answers: mut all_answers } = self;
        let any = all_answers.any();
        let mut projection = Projection::<S>::empty();
        let (mut room, mut results) = (Room::default(), Results::default());
        let (mut counts, mut others) = (Counts::default(), Vec::new());
        let (mut at, mut size) = (0, RAYS);
        while at < all.len() {
            let end = (at + size).min(all.len());
            let (rays, next) = (&all[at..end], &all[end..]);

            // Coherent rays make a bundle, unless they go too far apart: then a smaller one.
            results.clear();
            let outcome = match bundle_of(rays, next, test, any) {
                None => Outcome::NotCoherent,
                Some(rays) => S::vectorize(
                    #[inline(always)]
                    || {
                        let room = (&mut projection, &mut room, &mut results);
                        Bundle { bvh, test, any }.trace::<S>(&rays, room, &mut counts)
                    },
                ),
            };
            let (is_bundle, left, work) = match outcome {
                Outcome::Traced { left, work } => {
                    let answers = all_answers.part(at, end);
                    let rays = (rays, on_grid.get(at..end).unwrap_or(&[]));
                    S::vectorize(
                        #[inline(always)]
                        || results.write::<S>(bvh, test.resolver(), rays, answers),
                    );
                    (true, left, work)
                }
                Outcome::TooWide if size > SMALLEST => {
                    size /= 4;
                    continue;
                }
                Outcome::TooWide | Outcome::NotCoherent => (false, u64::MAX, 0),
            };

            // The others wait for some more of them, unless some hit was asked for and is found.
            if left != 0 || projection.has_outliers {
                let over = |ray: usize| any && results.is_hit(ray);
                let is_left =
                    |ray: usize| left >> (ray / 16) & 1 != 0 || projection.is_outlier(ray);
                let waits = |ray: &usize| is_left(*ray) && !over(*ray);
                others.extend((0..rays.len()).filter(waits).map(|ray| (at + ray) as u32));
            }
            at = end;
            size = next_size(size, at, work > BUSY * rays.len());

            let enough = if is_bundle { usize::MAX } else { STREAM };
            if others.len() >= enough || at == all.len() && !others.is_empty() {
                let (answers, counts) = (&mut all_answers, &mut counts);
                let numbers = &others[..];
                test.level().run(Stream {
                    bvh,
                    test,
                    rays: all,
                    on_grid,
                    numbers,
                    answers,
                    counts,
                });
                others.clear();
            }
        }
        counts
    }
}

/// Some rays as a bundle, if they share their origin; or if any hit will do, which can be asked from where
/// rays end, too, their end.
#[inline(always)]
fn bundle_of<'a>(
    rays: &'a [Ray],
    next: &'a [Ray],
    test: Filter,
    any: bool,
) -> Option<BundleRays<'a>> {
    if shares_origin(rays) {
        return Some(BundleRays { rays, next, reversed: None });
    }
    if !any || !test.resolver().may_reverse() {
        return None;
    }
    let reversed = CommonEnd::of(rays, test.threshold());
    reversed.is_some().then_some(BundleRays { rays, next, reversed })
}

/// How many rays the next bundle has: it may be larger again where a larger one would begin.
fn next_size(mut size: usize, at: usize, is_busy: bool) -> usize {
    let most = if is_busy { BUSY_RAYS } else { RAYS };
    while size < most && at.is_multiple_of(4 * size) {
        size *= 4;
    }
    size.min(most)
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

    /// A picture of the sheet, and what a light sees of it: bundles are traced and change nothing.
    #[test]
    fn bundles_are_taken_and_change_nothing() {
        bundles_change_nothing(&sheet(1));
    }

    /// Some thirty triangles a ray: bundles are tried, and most rays go one by one.
    #[test]
    fn bundles_that_are_too_dense_change_nothing() {
        bundles_change_nothing(&sheet(12));
    }

    fn bundles_change_nothing(bvh: &Bvh) {
        // The direction of one ray is foreign to its bundle.
        let ray = |i: usize| {
            let (square, i) = (i / 256, i % 256);
            let at = |k: usize| (k as f32 - 28.0) / 40.0;
            let dir = [at(square % 4 * 16 + i % 16), at(square / 4 * 16 + i / 16), -1.0];
            Ray::new([14.3, 15.1, 25.0], dir)
        };
        let mut rays: Vec<Ray> = (0..4096).map(ray).collect();
        rays[700].dir = [0.0, 1.0, 0.2];

        let mode = Certified::default();
        let (mut hits, mut any) = (vec![Hit::MISS; rays.len()], vec![false; rays.len()]);
        bvh.closest_batch(&mode, &rays, &mut hits);
        bvh.any_batch(&mode, &rays, &mut any);
        for ((ray, hit), any) in rays.iter().zip(&hits).zip(&any) {
            assert_eq!(hit.some(), bvh.closest(&mode, ray));
            assert_eq!(*any, hit.is_hit());
        }
        assert!(hits.iter().filter(|hit| hit.is_hit()).count() > 2000);

        // In another order the same rays have little in common.
        let mixed: Vec<Ray> = (0..4096).map(|i| rays[i * 1021 % 4096]).collect();
        let bundled = hits.clone();
        bvh.closest_batch(&mode, &mixed, &mut hits);
        for (i, hit) in hits.iter().enumerate() {
            assert_eq!(*hit, bundled[i * 1021 % 4096]);
        }
    }
}
