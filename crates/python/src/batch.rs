//! Batches of rays: threads take them in chunks, gather each chunk from numpy's arrays into the
//! cache, and trace it there.

use intertri::RayOf;
use pyo3::prelude::*;

use crate::picture::{band, gather, prefetch_next, row_width};
use crate::pool::{Workers, chunks};
use crate::run::{Stop, run};
use crate::scalar::Scalar;
use crate::skip::Skip;
use crate::source::Source;

/// The number of rays that a thread takes at a time.
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
    run(py, workers, |stop| match row_width(rays, width) {
        Some(width) => by_tiles(rays, width, (answers, none), &ask, stop),
        None => chunks(answers, CHUNK, Vec::new, |gathered, number, answers| {
            if !stop.is_set() {
                let first = number * CHUNK;
                let range = first..first + answers.len();
                ask(rays.rays(range.clone(), gathered), rays.skip(range), answers);
            }
        }),
    })
}

/// [`answers`] for a picture whose rows have `width` pixels.
fn by_tiles<S: Scalar, A: Copy + Send + Sync>(
    rays: &Source<'_, S>,
    width: usize,
    (answers, none): (&mut [A], A),
    ask: &(impl Fn(&[RayOf<S>], Skip<'_>, &mut [A]) + Sync),
    stop: &Stop,
) {
    let whole = band(width, rays.count);
    chunks(
        answers,
        whole.pixels(),
        || (Vec::new(), Vec::new()),
        |(gathered, found), number, answers| {
            let (first, band) = (number * whole.pixels(), whole.within(answers.len()));
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
            let cut = first + band.pixels()..first + answers.len();
            ask(rays.rays(cut, gathered), Skip::NONE, &mut answers[band.pixels()..]);
        },
    );
}
