//! Traces many rays in chunks on all threads. Each chunk dispatches to the CPU's SIMD level once.
//!
//! ```text
//!   closest_batch ──► runs ──► pieces over threads ──────────► trace_part ──► bundles, packets or
//!                      │             │ one apex                  ▲   │        streams
//!                      │             ├──► hide (any hit)         │   │
//!                      │             └──► sort ──────────────► gather └──► scatter
//!                      │ rows of pixels                          ▲
//!                      └──► bands over threads ──────────────────┘
//! ```

mod answer;
mod apex;
mod choice;
mod chunk;
mod lists;
mod occluders;
pub(crate) mod rows;
mod sorter;
pub(crate) mod tiles;

pub(crate) use answer::Answer;
pub use answer::HitRecord;
pub(crate) use lists::lists;
pub use lists::{CrossingLists, HitLists, Lists};

use std::ops::Range;
use std::sync::Mutex;

use intertri::{Counts, Mode, RayOf};

use crate::scalar::Backend;
use crate::selection::ActiveSelection;
use crate::tree::Tree;
use crate::util::threads;
use crate::walk::BatchOutput;
use apex::{SortKey, Sorting, WIDE_WINDOW};
pub(crate) use choice::Choice;
use chunk::Chunk;
use occluders::Occluders;
use rows::{Run, runs};
use sorter::Sorter;
use tiles::Band;

/// The minimum number of rays that a thread takes at a time.
const CHUNK: usize = 4096;
/// The maximum number of rays that a thread takes at a time, as a multiple of [`CHUNK`]. Long
/// chunks help because each bundle determines the size of the next.
const CHUNKS: usize = 16;

/// The number of chunks per thread, and the number if rays are sorted: the more rays are sorted together,
/// the closer together they are.
const CHUNKS_PER_THREAD: usize = 16;
const SORTED_CHUNKS: usize = 4;

/// The minimum number of rays that a thread takes at a time if there are too few for full chunks.
const SMALLEST: usize = 256;

/// The rays of one call, with the query's mode and selection.
pub(crate) struct RayBatch<'a, S: Backend> {
    pub(crate) tree: &'a Tree,
    pub(crate) originals: &'a S::Originals,
    pub(crate) mode: Mode,
    pub(crate) selection: ActiveSelection<'a>,
    pub(crate) rays: &'a [RayOf<S>],
}

impl<S: Backend> RayBatch<'_, S> {
    /// Traces all rays, on all available threads. Rows of pixels are traced in tiles.
    ///
    /// # Panics
    /// Panics if there is not one answer per ray.
    pub(crate) fn trace<A: Answer>(&self, answers: &mut [A]) -> Counts {
        assert_eq!(self.rays.len(), answers.len(), "there must be one answer per ray");
        let is_sorted = |run: &Run| self.sorting::<A>(&run.rays).is_some();
        let pieces = |run| (Pieces::of(&run, is_sorted), run);
        let runs: Vec<_> = self.runs::<A>().into_iter().map(pieces).collect();
        let (mut pieces, mut rest) = (Vec::new(), answers);
        for (of, run) in &runs {
            let (some, others) = std::mem::take(&mut rest).split_at_mut(run.rays.len());
            let begins = run.rays.clone().step_by(of.size);
            pieces.extend(
                begins.zip(some.chunks_mut(of.size)).map(|piece| (of.band.as_ref(), piece)),
            );
            rest = others;
        }
        // Each piece begins with what others have learned.
        let learned = Mutex::new(Choice::new(A::ANY));
        add(pieces.into_iter(), |(band, (begin, answers))| {
            let mut choice = learned.lock().map_or_else(|e| e.into_inner().clone(), |c| c.clone());
            let counts = match band {
                Some(band) => self.trace_band(band, begin, answers, &mut choice),
                None => self.trace_others(begin, answers, &mut choice),
            };
            if let Ok(mut learned) = learned.lock() {
                *learned = choice;
            }
            counts
        })
    }

    /// Splits the rays into runs that are traced in the same way.
    fn runs<A: Answer>(&self) -> Vec<Run> {
        // Only bundles and packets benefit from tiles. They do not support selections, whose lists
        // follow the order of the rays.
        if A::IN_BUNDLES && self.selection.is_none() {
            let line =
                |i: usize| [self.rays[i].origin, self.rays[i].dir].map(|of| of.map(Into::into));
            runs(self.rays.len(), line)
        } else {
            vec![Run { rays: 0..self.rays.len(), width: None }]
        }
    }

    /// Returns how some of the rays are to be sorted, if they are.
    fn sorting<A: Answer>(&self, rays: &Range<usize>) -> Option<Sorting> {
        // As for tiles, only bundles benefit.
        let in_bundles = A::IN_BUNDLES && self.selection.is_none();
        in_bundles.then(|| apex::sorting(&self.rays[rays.clone()], A::ANY)).flatten()
    }

    /// Traces rays that are not pixels in rows on this thread, starting at ray `begin`. For any hit, rays
    /// that occluders of other rays hide are answered first. Rays with a common origin, end, or
    /// direction are sorted if their order is not coherent.
    fn trace_others<A: Answer>(
        &self,
        begin: usize,
        answers: &mut [A],
        choice: &mut Choice,
    ) -> Counts {
        let all = begin..begin + answers.len();
        let sorting = self.sorting::<A>(&all);
        // Neither supports selections.
        if sorting.is_none() && (!A::ANY || self.selection.is_some()) {
            return self.trace_part(all, A::output(answers), choice);
        }
        let window = sorting.map_or(WIDE_WINDOW, |sorting| sorting.window);
        let (mut sorting, mut occluders) = (WindowSorting::new(sorting), Occluders::new());
        let (mut left, mut rest) = (Gathered::default(), Vec::new());
        let mut counts = Counts::default();
        for (rays, answers) in self.rays[all].chunks(window).zip(answers.chunks_mut(window)) {
            let batch = RayBatch { rays, ..*self };
            rest.clear();
            let some_are_hidden = match A::output(answers) {
                BatchOutput::Any(any) => {
                    let are_many = batch.hides_some(&mut occluders, any, &mut counts);
                    if are_many {
                        let indices = (0..=u16::MAX).zip(&*any).filter(|(_, any)| !**any);
                        rest.extend(indices.map(|(i, _)| i));
                    }
                    are_many
                }
                _ => false,
            };
            counts += if some_are_hidden {
                left.trace(&batch, &rest, answers, |batch, found| {
                    batch.trace_window(&mut sorting, found, choice)
                })
            } else {
                batch.trace_window(&mut sorting, answers, choice)
            };
        }
        counts
    }

    /// Sets the answers of rays that are certain to be hidden by the occluders of other rays. Returns
    /// whether it is worth tracing only the others.
    fn hides_some(&self, occluders: &mut Occluders, any: &mut [bool], counts: &mut Counts) -> bool {
        occluders.hide(any, |occluders, range, any| {
            let (start, mut hidden) = (range.start, 0);
            self.pieces(range, |chunk, piece| {
                let any = &mut any[piece.start - start..piece.end - start];
                hidden += occluders.test((chunk.tree, &chunk.filter), chunk.rays, any, counts);
            });
            hidden
        })
    }

    /// Traces up to 2^16 rays, and sorts them first if they have something in common.
    fn trace_window<A: Answer>(
        &self,
        sorting: &mut WindowSorting<S, A>,
        answers: &mut [A],
        choice: &mut Choice,
    ) -> Counts {
        let WindowSorting { key, sorter, sorted } = sorting;
        let Some(key) = *key else {
            return self.trace_part(0..answers.len(), A::output(answers), choice);
        };
        let order = sorter.sort(self.mode.level(), (key, self.rays));
        sorted.trace(self, order, answers, |batch, answers| {
            batch.trace_part(0..answers.len(), A::output(answers), choice)
        })
    }

    /// Traces rows of pixels on this thread, starting at ray `begin`.
    fn trace_band<A: Answer>(
        &self,
        whole: &Band,
        begin: usize,
        answers: &mut [A],
        choice: &mut Choice,
    ) -> Counts {
        let (mut gathered, mut found, mut counts) = (Vec::new(), Vec::new(), Counts::default());
        let band = whole.within(answers.len());
        for block in band.blocks() {
            block.gather(&self.rays[begin..], &mut gathered);
            block.prefetch_next(&self.rays[begin..]);
            found.resize(gathered.len(), A::MISS);
            let batch = RayBatch { rays: &gathered, ..*self };
            counts += batch.trace_part(0..gathered.len(), A::output(&mut found), choice);
            block.scatter(&found, answers);
        }
        counts
    }

    /// Traces a range of the rays on this thread. `choice` is what was learned from earlier ranges.
    pub(crate) fn trace_part(
        &self,
        range: Range<usize>,
        mut output: BatchOutput<'_>,
        choice: &mut Choice,
    ) -> Counts {
        let (start, mut counts) = (range.start, Counts::default());
        self.pieces(range, |chunk, piece| {
            let output = output.part(piece.start - start, piece.end - start);
            counts += chunk.trace(output, choice);
        });
        output.rename(self.tree);
        counts
    }

    /// Passes the rays to a traversal in f32, piece by piece.
    fn pieces(&self, range: Range<usize>, mut trace: impl FnMut(Chunk<'_>, Range<usize>)) {
        let Self { tree, originals, mode, selection, rays } = *self;
        for from in range.clone().step_by(S::PIECE) {
            let piece = from..range.end.min(from.saturating_add(S::PIECE));
            let selection = selection.map(|selection| selection.part(piece.start, piece.end));
            S::with_rays(tree, originals, mode, (rays, piece.clone()), |filter, rays| {
                trace(Chunk { tree, filter, selection, rays }, piece);
            });
        }
    }
}

/// What windows of rays are sorted by, if they are, and the memory for that.
struct WindowSorting<S: Backend, A> {
    key: Option<SortKey>,
    sorter: Sorter,
    sorted: Gathered<S, A>,
}

impl<S: Backend, A: Answer> WindowSorting<S, A> {
    fn new(sorting: Option<Sorting>) -> Self {
        let key = sorting.map(|sorting| sorting.key);
        Self { key, sorter: Sorter::default(), sorted: Gathered::default() }
    }
}

/// Rays that are traced in another order, and their answers. The memory is used again.
struct Gathered<S: Backend, A> {
    rays: Vec<RayOf<S>>,
    answers: Vec<A>,
}

impl<S: Backend, A> Default for Gathered<S, A> {
    fn default() -> Self {
        Self { rays: Vec::new(), answers: Vec::new() }
    }
}

impl<S: Backend, A: Answer> Gathered<S, A> {
    /// Traces the rays in the given places of a batch, in this order, and stores their answers there.
    fn trace(
        &mut self,
        batch: &RayBatch<'_, S>,
        order: &[u16],
        answers: &mut [A],
        trace: impl FnOnce(&RayBatch<'_, S>, &mut [A]) -> Counts,
    ) -> Counts {
        self.rays.clear();
        self.rays.extend(order.iter().map(|&i| batch.rays[usize::from(i)]));
        self.answers.resize(order.len(), A::MISS);
        let counts = trace(&RayBatch { rays: &self.rays, ..*batch }, &mut self.answers);
        for (&i, &answer) in order.iter().zip(&self.answers) {
            answers[usize::from(i)] = answer;
        }
        counts
    }
}

/// Computes one answer per item, in chunks on all threads.
///
/// # Panics
/// Panics if the slices differ in length.
pub(crate) fn chunks<R: Sync, A: Send>(
    of: &[R],
    answers: &mut [A],
    each: impl Fn(&[R], &mut [A]) -> Counts + Sync,
) -> Counts {
    assert_eq!(of.len(), answers.len(), "there must be one answer per item");
    let size = chunk_size(of.len(), CHUNKS_PER_THREAD);
    add(of.chunks(size).zip(answers.chunks_mut(size)), |(of, answers)| each(of, answers))
}

/// Sums the counts of pieces, each of which is processed by one thread.
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

/// The distribution of a run's rays among threads.
struct Pieces {
    /// The number of rays in a piece.
    size: usize,
    /// The shape of a piece, if the rays are pixels in rows.
    band: Option<Band>,
}

impl Pieces {
    fn of(run: &Run, is_sorted: impl FnOnce(&Run) -> bool) -> Self {
        let rays = run.rays.len();
        let Some(width) = run.width else {
            let each = if is_sorted(run) { SORTED_CHUNKS } else { CHUNKS_PER_THREAD };
            return Self { size: chunk_size(rays, each), band: None };
        };
        let band = Band::of_picture(width, rays, threads::count());
        Self { size: band.pixels(), band: Some(band) }
    }
}

/// Returns a chunk size for which each thread gets about `each` chunks, so that all threads finish at
/// about the same time.
fn chunk_size(rays: usize, each: usize) -> usize {
    let threads = threads::count();
    if rays < threads * CHUNK {
        return rays.div_ceil(threads).next_multiple_of(SMALLEST).max(SMALLEST);
    }
    // A single thread does not have to wait for other threads.
    let each = if threads == 1 { 1 } else { each };
    (rays / (each * threads)).next_multiple_of(CHUNK).clamp(CHUNK, CHUNKS * CHUNK)
}

#[cfg(test)]
mod tests {
    use intertri::{Hit, Mode, Ray, Ray64, Triangle, TriangleOf};

    use crate::Bvh;

    /// Returns a bumpy sheet of 30×30 units, divided into `squares`×`squares` squares.
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

    /// Closest-hit and any-hit queries for an image of the sheet use bundles, which do not change
    /// the results.
    #[test]
    fn bundles_are_taken_and_change_nothing() {
        bundles_change_nothing(&sheet(30));
    }

    /// With many rays per triangle, the values that rays share are computed once.
    #[test]
    fn bundles_that_share_triangles_change_nothing() {
        bundles_change_nothing(&sheet(7));
    }

    /// With about thirty triangles per ray, bundles are tried, but most rays are traced one by one.
    #[test]
    fn bundles_that_are_too_dense_change_nothing() {
        bundles_change_nothing(&sheet(360));
    }

    fn bundles_change_nothing(bvh: &Bvh) {
        // One ray's direction differs from the directions of the other rays in its bundle.
        let ray = |i: usize| {
            let (square, i) = (i / 256, i % 256);
            let at = |k: usize| (k as f32 - 28.0) / 40.0;
            let dir = [at(square % 4 * 16 + i % 16), at(square / 4 * 16 + i / 16), -1.0];
            Ray::new([14.3, 15.1, 25.0], dir)
        };
        let mut rays: Vec<Ray> = (0..4096).map(ray).collect();
        rays[700].dir = [0.0, 1.0, 0.2];

        let mode = Mode::certified();
        let (mut hits, mut any) = (vec![Hit::MISS; rays.len()], vec![false; rays.len()]);
        bvh.query().mode(mode).closest_batch_into(&rays, &mut hits);
        bvh.query().mode(mode).any_batch_into(&rays, &mut any);
        for ((ray, hit), any) in rays.iter().zip(&hits).zip(&any) {
            assert_eq!(hit.some(), bvh.query().mode(mode).closest(ray));
            assert_eq!(*any, hit.is_hit());
        }
        assert!(hits.iter().filter(|hit| hit.is_hit()).count() > 2000);

        // List every hit of each ray. Hits of packets that a bundle did not trace must be listed
        // exactly once.
        let exact = Mode::exact();
        let (lists, of_exact) = (
            bvh.query().mode(mode).all_batch(&rays, None),
            bvh.query().mode(exact).all_batch(&rays, None),
        );
        let (lists, of_exact) = (lists.unwrap(), of_exact.unwrap());
        assert!(
            lists.iter().zip(&rays).all(|(hits, ray)| *hits == bvh.query().mode(mode).all(ray))
        );
        assert!(
            of_exact.iter().zip(&rays).all(|(hits, ray)| *hits == bvh.query().mode(exact).all(ray))
        );
        assert!(lists.items.len() > 2000 && of_exact.items.len() > 2000);

        // Repeat the test in f64, with coordinates that are not exact in f32.
        let off = |x: f32| f64::from(x) + 1e-9;
        let corners = |triangle: &Triangle| TriangleOf(triangle.0.map(|corner| corner.map(off)));
        let triangles: Vec<_> = bvh.to_triangles().iter().map(corners).collect();
        let wide = |ray: &Ray| Ray64::new(ray.origin.map(off), ray.dir.map(off));
        let (bvh64, rays64) = (Bvh::new(&triangles).unwrap(), rays.iter().map(wide));
        let rays64: Vec<_> = rays64.collect();
        let of_f64 = bvh64.query().all_batch(&rays64, None).unwrap();
        assert!(of_f64.iter().zip(&rays64).all(|(hits, ray)| *hits == bvh64.query().all(ray)));
        assert!(of_f64.items.len() > 2000);

        // If the same rays are in another order, they are not coherent.
        let mixed: Vec<Ray> = (0..4096).map(|i| rays[i * 1021 % 4096]).collect();
        let bundled = hits.clone();
        bvh.query().mode(mode).closest_batch_into(&mixed, &mut hits);
        for (i, hit) in hits.iter().enumerate() {
            assert_eq!(*hit, bundled[i * 1021 % 4096]);
        }
    }
}
