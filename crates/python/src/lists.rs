//! Runs queries that return a list of answers, of any length, for each ray.
//!
//! Threads take bands of rays in order and store the answers of each band after those of the
//! previous bands:
//!
//! ```text
//!   bands of rays      0  1  2  3  4  5           Each thread takes the next band.
//!   answers of bands   0  1     3                 Band 3 waits until 2 determines its position.
//!   one array          0000011                    Each thread writes its own band.
//! ```

use std::ops::Range;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};

use bytemuck::Pod;
use intertri::RayOf;
use intertri_trace::internal::{Band, StopToken};
use numpy::{Element, PyArray1, PyArrayMethods};
use pyo3::prelude::*;
use pyo3::types::IntoPyDict;
use rayon::prelude::*;

use crate::joined::Joined;
use crate::part::Part;
use crate::picture::{Piece, gather, pieces};
use crate::pool::{Workers, is_caller};
use crate::run::{Stop, run};
use crate::scalar::Scalar;
use crate::skip::Skip;
use crate::source::Source;

/// The number of rays that a thread takes at a time.
const CHUNK: usize = 4096;

/// The offsets and the answers, the latter as 64-bit words. The answers of ray i are those from
/// `offsets[i]` to `offsets[i + 1]`.
pub(crate) type Lists<'py> = (Bound<'py, PyArray1<i64>>, Bound<'py, PyArray1<u64>>);

/// Runs a query that returns a list for each ray.
pub(crate) fn lists<'py, S: Scalar, A: Pod + Send + Sync>(
    py: Python<'py>,
    workers: &Workers,
    rays: &Source<'_, S>,
    width: usize,
    ask: impl Fn(&[RayOf<S>], Skip<'_>) -> PyResult<Part<A>> + Sync,
) -> PyResult<Lists<'py>> {
    // Reserve space for one answer per ray, if there is enough memory. Pages that are not needed
    // are never touched.
    let words_of = |answers: usize| answers * size_of::<A>() / size_of::<u64>();
    let offsets = zeros::<i64>(py, rays.count + 1)?;
    let words = zeros::<u64>(py, words_of(rays.count)).or_else(|_| zeros(py, 0))?;
    let (put, more) = {
        let (mut offsets, mut words) = (offsets.readwrite(), words.readwrite());
        let joined = Joined::new(&mut offsets.as_slice_mut()?[1..], words.as_slice_mut()?);
        run(py, workers, |stop| {
            let asking = Asking { rays, ask: &ask, stop };
            asking.all(&pieces(rays, width, CHUNK), &joined)
        })??;
        joined.finish()
    };
    if more.is_empty() {
        let keys = [("refcheck", false)].into_py_dict(py)?;
        words.call_method("resize", (words_of(put),), Some(&keys))?;
        return Ok((offsets, words));
    }

    // Some answers did not fit, so copy everything into one array.
    let all = put + more.iter().map(|part| part.answers.len()).sum::<usize>();
    let together = zeros::<u64>(py, words_of(all))?;
    {
        let (words, mut together) = (words.readonly(), together.readwrite());
        let (words, mut rest) = (&words.as_slice()?[..words_of(put)], together.as_slice_mut()?);
        let answers = more.iter().map(|part| bytemuck::cast_slice(&part.answers));
        let pieces = [words].into_iter().chain(answers).map(|words: &[u64]| {
            let (to, others) = std::mem::take(&mut rest).split_at_mut(words.len());
            rest = others;
            (to, words)
        });
        let pieces: Vec<_> = pieces.collect();
        let copy = |(to, words): (&mut [u64], &[u64])| to.copy_from_slice(words);
        py.detach(|| {
            workers.install(|| {
                if is_caller() {
                    pieces.into_iter().for_each(copy);
                } else {
                    pieces.into_par_iter().for_each(copy);
                }
            });
        });
    }
    Ok((offsets, together))
}

/// The query and its rays.
struct Asking<'a, S, F> {
    rays: &'a Source<'a, S>,
    ask: &'a F,
    stop: &'a Stop,
}

impl<S, F, A> Asking<'_, S, F>
where
    S: Scalar,
    F: Fn(&[RayOf<S>], Skip<'_>) -> PyResult<Part<A>> + Sync,
    A: Pod + Send + Sync,
{
    /// Queries all rays on all threads.
    fn all(&self, pieces: &[Piece], joined: &Joined<'_, A>) -> PyResult<()> {
        let (next, has_failed) = (AtomicUsize::new(0), AtomicBool::new(false));
        let work = || {
            let mut gathered = Vec::new();
            loop {
                let number = next.fetch_add(1, Ordering::Relaxed);
                let Some(Piece { rays, band }) = pieces.get(number) else { return Ok(()) };
                if self.stop.is_set() || has_failed.load(Ordering::Relaxed) {
                    return Ok(());
                }
                let mut part = joined.part();
                let done = match band {
                    Some(band) => self.band(band, rays.clone(), &mut gathered, &mut part),
                    None => self.range(rays.clone(), &mut gathered, &mut part),
                };
                if done.is_err() {
                    has_failed.store(true, Ordering::Relaxed);
                    return done;
                }
                joined.put(number, part);
            }
        };
        if is_caller() {
            return work();
        }
        let token = StopToken::current();
        rayon::broadcast(|_| token.run(work)).into_iter().collect()
    }

    /// Appends the lists of the rays in a range, traced in the given order.
    fn range(
        &self,
        range: Range<usize>,
        gathered: &mut Vec<RayOf<S>>,
        part: &mut Part<A>,
    ) -> PyResult<()> {
        if !range.is_empty() && !self.stop.is_set() {
            let rays = self.rays.rays(range.clone(), gathered);
            let found = (self.ask)(rays, self.rays.skip(range))?;
            part.reserve(found.rays(), found.answers.len())?;
            part.add(&found, (0, found.rays()));
        }
        Ok(())
    }

    /// Appends the lists of a band of an image, block by block.
    fn band(
        &self,
        whole: &Band,
        Range { start: first, end }: Range<usize>,
        gathered: &mut Vec<RayOf<S>>,
        part: &mut Part<A>,
    ) -> PyResult<()> {
        let band = whole.within(end - first);
        let mut blocks = Vec::new();
        for block in band.blocks() {
            if self.stop.is_set() {
                return Ok(());
            }
            gather(&block, (self.rays, first), gathered);
            blocks.push((block, (self.ask)(gathered, Skip::NONE)?));
        }
        let answers = blocks.iter().map(|(_, found)| found.answers.len()).sum();
        part.reserve(band.pixels(), answers)?;
        for row in 0..band.rows() {
            for (block, found) in &blocks {
                for four in block.fours(row) {
                    part.add(found, four);
                }
            }
        }
        self.range(first + band.pixels()..end, gathered, part)
    }
}

/// Creates an array of zeros. The system provides it without writing to its pages. Returns an error
/// if memory runs out, whereas the `numpy` crate's function panics.
fn zeros<T: Element>(py: Python<'_>, count: usize) -> PyResult<Bound<'_, PyArray1<T>>> {
    let made = py.import("numpy")?.call_method1("zeros", (count, T::get_dtype(py)))?;
    Ok(made.cast_into()?)
}
