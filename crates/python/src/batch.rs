//! Traces batches of rays. Each thread repeatedly takes a band of an image, or a chunk of rays that
//! do not form an image. It gathers the rays of a band from the numpy arrays block by block, so
//! that they are in the cache when they are traced. A chunk is gathered as a whole, or borrowed if
//! the array contains whole rays.

use intertri::RayOf;
use pyo3::prelude::*;

use crate::picture::{gather, pieces, prefetch_next};
use crate::pool::{Workers, distribute};
use crate::run::run;
use crate::scalar::Scalar;
use crate::skip::Skip;
use crate::source::Source;

/// The number of rays that a thread takes at a time if the rays do not form an image.
const CHUNK: usize = 8192;

/// Runs a query with one answer per ray. `none` is an arbitrary initial value.
pub(crate) fn answers<S: Scalar, A: Copy + Send + Sync>(
    py: Python<'_>,
    workers: &Workers,
    rays: &Source<'_, S>,
    width: usize,
    (answers, none): (&mut [A], A),
    ask: impl Fn(&[RayOf<S>], Skip<'_>, &mut [A]) + Sync,
) -> PyResult<()> {
    run(py, workers, |stop| {
        let mut rest = answers;
        let pieces = pieces(rays, width, CHUNK).into_iter().map(|piece| {
            let (some, others) = std::mem::take(&mut rest).split_at_mut(piece.rays.len());
            rest = others;
            (piece, some)
        });
        let memory = || (Vec::new(), Vec::new());
        distribute(pieces.collect(), memory, |(gathered, found), (piece, answers)| {
            let mut done = 0;
            if let Some(band) = &piece.band {
                let (band, first) = (band.within(answers.len()), piece.rays.start);
                for block in band.blocks() {
                    if stop.is_set() {
                        return;
                    }
                    gather(&block, (rays, first), gathered);
                    prefetch_next(&block, (rays, first));
                    found.resize(gathered.len(), none);
                    ask(gathered, Skip::NONE, found);
                    block.scatter(found, answers);
                }
                done = band.pixels();
            }
            // Trace the rays that are in no block. These are all of the piece's rays if they do not
            // form an image; otherwise, they are the pixels of an incomplete last row.
            let rest = piece.rays.start + done..piece.rays.end;
            if !stop.is_set() && !rest.is_empty() {
                let skip = rays.skip(rest.clone());
                ask(rays.rays(rest, gathered), skip, &mut answers[done..]);
            }
        });
    })
}
