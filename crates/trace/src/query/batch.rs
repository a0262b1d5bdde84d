//! Many rays: in chunks over the threads, each chunk behind one entry into the CPU's level.

use intertri::internal::{Filter, Lanes64, Test, Which};
use intertri::simd::{Simd, WithSimd};
use intertri::{Counts, Hit, LaneQueries, Ray, fixed};

use std::ops::Range;
use std::sync::Mutex;

use crate::answers::Answers;
use crate::beam::Beams;
use crate::bundle::{
    Bundle, BundleRays, CommonEnd, Outcome, Projection, RAYS, Results, Scratch, shares_origin,
};
use crate::given::Ask;
use crate::place::Place;
use crate::select::Choice;
use crate::single::{Closest, Kept};
use crate::stop;
use crate::stream::Stream;
use crate::threads;
use crate::tree::Tree;

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

/// Rays that are asked in one call, as far as a chunk of them goes.
#[derive(Clone, Copy)]
pub(super) struct Asked<'a> {
    pub(super) bvh: &'a Tree,
    pub(super) choice: Choice<'a>,
    pub(super) rays: &'a [Ray],
    /// Of a grid, the rays as their caller has them; else none.
    pub(super) on_grid: &'a [fixed::Ray],
}

/// Asks about the rays of a range, as the walk goes over them.
type Rays<'a> = &'a (dyn Fn(Range<usize>, Ask<'_>) + Sync);

/// Rays of any scalar that are asked in one call.
pub(super) struct Many<'a> {
    pub(super) bvh: &'a Tree,
    pub(super) choice: Choice<'a>,
    pub(super) count: usize,
    /// So many are asked about at a time, so that copies of them stay in the cache.
    pub(super) piece: usize,
    pub(super) rays: Rays<'a>,
}

impl Many<'_> {
    /// Asks about the rays of a range.
    pub(super) fn ask(&self, range: Range<usize>, ask: &mut dyn FnMut(Asked<'_>, Which<'_>)) {
        let choice = self.choice.map(|choice| choice.part(range.start, range.end));
        (self.rays)(range, &mut |which, rays| {
            ask(Asked { bvh: self.bvh, choice, rays, on_grid: &[] }, *which);
        });
    }
}

/// The answer of each ray, on all threads where there are threads.
pub(super) fn answer(many: &Many<'_>, answers: Answers<'_>) -> Counts {
    let chunks = answers.chunks(many.count, chunk_size(many.count));
    add(chunks.into_iter(), |(range, answers)| part(many, range, answers))
}

/// The answers of some rays, on this thread.
pub(super) fn part(many: &Many<'_>, range: Range<usize>, mut answers: Answers<'_>) -> Counts {
    let mut counts = Counts::default();
    for from in range.clone().step_by(many.piece) {
        let to = range.end.min(from.saturating_add(many.piece));
        many.ask(from..to, &mut |asked, which| {
            let mut some = answers.part(from - range.start, to - range.start);
            counts += match which {
                Which::Filter(test) => match some {
                    Answers::Places(places) => beams(asked, test, places),
                    some => chunk(asked, test, some),
                },
                Which::Lanes64(test) => one_by_one(asked, test, &mut some),
            };
        });
    }
    tell(many.bvh, answers);
    counts
}

/// Where rays start that go the same way, on this thread: by beams, and those that are left as a stream.
fn beams(Asked { bvh, rays, .. }: Asked<'_>, test: Filter<'_>, places: &mut [Place]) -> Counts {
    let mut counts = Counts::default();
    let left = test.level().run(Beams { bvh, test, rays, places, counts: &mut counts });
    if !left.is_empty() {
        let (numbers, answers, counts) = (&left[..], &mut Answers::Places(places), &mut counts);
        let (rays, choice) = ((rays, &[][..]), &None);
        stream(Stream { bvh, test, rays, numbers, answers, choice, counts });
    }
    counts
}

/// Hits are told by geometry and number.
fn tell(bvh: &Tree, answers: Answers<'_>) {
    if let Answers::Hits(hits) = answers {
        bvh.geometries.tell(hits);
    }
}

/// A chunk of rays on this thread, by the filter: coherent rays in bundles, the others in streams.
pub(super) fn chunk<'a>(asked: Asked<'a>, test: Filter<'a>, answers: Answers<'_>) -> Counts {
    test.level().run(Chunk { asked, test, answers })
}

/// In f64 lanes: a ray a call, for this is only there to compare with.
fn one_by_one(asked: Asked<'_>, test: Lanes64, answers: &mut Answers<'_>) -> Counts {
    let Asked { bvh, choice, rays, .. } = asked;
    let mut counts = Counts::default();
    let kept = &mut *Kept::lend(bvh);
    for (number, ray) in rays.iter().enumerate() {
        let (test, choice) = (&test, (&choice, number));
        let (closest, some) = if answers.any() {
            test.level().run(Closest::<_, true> { bvh, test, ray, choice, kept })
        } else {
            test.level().run(Closest::<_, false> { bvh, test, ray, choice, kept })
        };
        counts += some;
        if !answers.write(number, &closest) {
            let hit = test.hit(ray, &closest, |place| bvh.triangle_in(place));
            answers.write_hit(number, hit.unwrap_or(Hit::MISS));
        }
    }
    counts
}

/// The answers of rays of any kind, in chunks over all threads.
///
/// # Panics
/// If the slices differ in length.
pub(crate) fn chunks<R: Sync, A: Send>(
    rays: &[R],
    answers: &mut [A],
    each: impl Fn(&[R], &mut [A]) -> Counts + Sync,
) -> Counts {
    assert_eq!(rays.len(), answers.len(), "one answer a ray");
    let size = chunk_size(rays.len());
    add(rays.chunks(size).zip(answers.chunks_mut(size)), |(rays, answers)| each(rays, answers))
}

/// The counts of some pieces, each done on one thread.
fn add<P: Send>(pieces: impl Iterator<Item = P>, each: impl Fn(P) -> Counts + Sync) -> Counts {
    let counts = Mutex::new(Counts::default());
    threads::pieces(pieces, |_, piece| {
        let some = each(piece);
        if let Ok(mut counts) = counts.lock() {
            *counts += some;
        }
    });
    counts.into_inner().unwrap_or_default()
}

/// Some chunks a thread, so that all are done at about the same time.
fn chunk_size(rays: usize) -> usize {
    let even = rays / (16 * threads::count());
    even.next_multiple_of(CHUNK).clamp(CHUNK, CHUNKS * CHUNK)
}

/// A chunk of rays.
struct Chunk<'a, 'b> {
    asked: Asked<'a>,
    test: Filter<'a>,
    answers: Answers<'b>,
}

impl WithSimd for Chunk<'_, '_> {
    type Output = Counts;

    #[inline(always)]
    fn run<S: Simd>(self) -> Counts {
        let Self { asked, test, answers: mut all_answers } = self;
        let Asked { bvh, choice, rays: all, on_grid } = asked;
        let (any, every) = (all_answers.any(), all_answers.every());
        // A bundle knows nothing of who counts, and crossings are counted ray by ray.
        let bundles = choice.is_none() && (!every || matches!(all_answers, Answers::Pairs(_)));
        let mut projection = Projection::<S>::empty();
        let (mut scratch, mut results) = (Scratch::default(), Results::default());
        let (mut counts, mut others) = (Counts::default(), Vec::new());
        let (mut at, mut size) = (0, RAYS);
        while at < all.len() {
            stop::check();
            let end = (at + size).min(all.len());
            let (rays, next) = (&all[at..end], &all[end..]);

            // Coherent rays make a bundle, unless they go too far apart: then a smaller one.
            results.clear();
            let bundle = if bundles { bundle_of((rays, next, at as u32), test, any) } else { None };
            let outcome = match bundle {
                None => Outcome::NotCoherent,
                Some(rays) => S::vectorize(
                    #[inline(always)]
                    || {
                        let scratch = (&mut projection, &mut scratch, &mut results);
                        Bundle { bvh, test, any, every }.trace::<S>(&rays, scratch, &mut counts)
                    },
                ),
            };
            let (is_bundle, left, work) = match outcome {
                Outcome::Traced { left, work } => {
                    let (resolver, first) = (test.resolver(), at as u32);
                    S::vectorize(
                        #[inline(always)]
                        || match all_answers.part(at, end) {
                            Answers::Pairs(pairs) => {
                                results.list::<S>(bvh, resolver, (rays, first, left), pairs);
                            }
                            answers => {
                                let on_grid = on_grid.get(at..end).unwrap_or(&[]);
                                results.write::<S>(bvh, resolver, (rays, on_grid, first), answers);
                            }
                        },
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
                let (answers, choice, counts) = (&mut all_answers, &choice, &mut counts);
                let (rays, numbers) = ((all, on_grid), &others[..]);
                stream(Stream { bvh, test, rays, numbers, answers, choice, counts });
                others.clear();
            }
        }
        counts
    }
}

/// Not inlined into the chunks of every level, or each would have the streams of every level again.
#[inline(never)]
fn stream(stream: Stream<'_, '_>) {
    stream.test.level().run(stream);
}

/// Some rays as a bundle, if they share their origin; or if any hit will do, which can be asked from where
/// rays end, too, their end.
#[inline(always)]
fn bundle_of<'a>(
    (rays, next, first): (&'a [Ray], &'a [Ray], u32),
    test: Filter<'_>,
    any: bool,
) -> Option<BundleRays<'a>> {
    if shares_origin(rays) {
        return Some(BundleRays { rays, first, next, reversed: None });
    }
    if !any || !test.resolver().may_reverse() {
        return None;
    }
    let reversed = CommonEnd::of(rays, test.threshold());
    reversed.is_some().then_some(BundleRays { rays, first, next, reversed })
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
    use intertri::{Certified, Exact, Hit, Ray, Ray64, Triangle, TriangleOf};

    use crate::Bvh;

    /// A bumpy sheet of 30 by 30 units, of so many squares a side.
    fn sheet(squares: usize) -> Bvh {
        let size = 30.0 / squares as f32;
        let corner =
            |x: usize, y: usize| [x as f32 * size, y as f32 * size, (x * y % 5) as f32 * 0.1];
        let mut triangles = Vec::new();
        for i in 0..squares * squares {
            let (x, y) = (i % squares, i / squares);
            triangles.push(Triangle([corner(x, y), corner(x + 1, y), corner(x, y + 1)]));
            triangles.push(Triangle([corner(x + 1, y + 1), corner(x + 1, y), corner(x, y + 1)]));
        }
        Bvh::new(&triangles).unwrap()
    }

    /// A picture of the sheet, and what a light sees of it: bundles are traced and change nothing.
    #[test]
    fn bundles_are_taken_and_change_nothing() {
        bundles_change_nothing(&sheet(30));
    }

    /// Many rays a triangle: what they share is computed once.
    #[test]
    fn bundles_that_share_triangles_change_nothing() {
        bundles_change_nothing(&sheet(7));
    }

    /// Some thirty triangles a ray: bundles are tried, and most rays go one by one.
    #[test]
    fn bundles_that_are_too_dense_change_nothing() {
        bundles_change_nothing(&sheet(360));
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

        // Every hit, to the sheet and beyond: those of packets that are left are listed once.
        let exact = Exact::default();
        let (lists, of_exact) =
            (bvh.all_batch(&mode, &rays, None), bvh.all_batch(&exact, &rays, None));
        let (lists, of_exact) = (lists.unwrap(), of_exact.unwrap());
        assert!(lists.iter().zip(&rays).all(|(hits, ray)| *hits == bvh.all(&mode, ray)));
        assert!(of_exact.iter().zip(&rays).all(|(hits, ray)| *hits == bvh.all(&exact, ray)));
        assert!(lists.hits.len() > 2000 && of_exact.hits.len() > 2000);

        // The same in f64, off from what f32 holds.
        let off = |x: f32| f64::from(x) + 1e-9;
        let corners = |triangle: &Triangle| TriangleOf(triangle.0.map(|corner| corner.map(off)));
        let triangles: Vec<_> = bvh.to_triangles().iter().map(corners).collect();
        let wide = |ray: &Ray| Ray64::new(ray.origin.map(off), ray.dir.map(off));
        let (bvh64, rays64) = (Bvh::new(&triangles).unwrap(), rays.iter().map(wide));
        let rays64: Vec<_> = rays64.collect();
        let of_f64 = bvh64.all_batch(&exact, &rays64, None).unwrap();
        assert!(of_f64.iter().zip(&rays64).all(|(hits, ray)| *hits == bvh64.all(&exact, ray)));
        assert!(of_f64.hits.len() > 2000);

        // In another order the same rays have little in common.
        let mixed: Vec<Ray> = (0..4096).map(|i| rays[i * 1021 % 4096]).collect();
        let bundled = hits.clone();
        bvh.closest_batch(&mode, &mixed, &mut hits);
        for (i, hit) in hits.iter().enumerate() {
            assert_eq!(*hit, bundled[i * 1021 % 4096]);
        }
    }
}
