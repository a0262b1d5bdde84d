//! Many rays: in chunks over the threads, each gathered from numpy's arrays into the cache and traced there.

use intertri::RayOf;
use pyo3::prelude::*;
use rayon::ThreadPool;
use rayon::prelude::*;

use crate::picture::{Band, row_width};
use crate::run::{Stop, run};
use crate::scalar::Scalar;
use crate::source::Source;

/// Rays a thread takes at a time.
const CHUNK: usize = 8192;

/// Asks for one answer a ray; `none` is any.
pub(crate) fn answers<S: Scalar, A: Copy + Send + Sync>(
    py: Python<'_>,
    pool: &ThreadPool,
    rays: &Source<'_, S>,
    width: usize,
    (answers, none): (&mut [A], A),
    ask: impl Fn(&[RayOf<S>], &mut [A]) + Sync,
) -> PyResult<()> {
    run(py, pool, rays.count, |stop| match row_width(rays, width) {
        Some(width) => by_tiles(rays, width, (answers, none), &ask, stop),
        None => answers.par_chunks_mut(CHUNK).enumerate().for_each_init(
            Vec::new,
            |gathered, (number, answers)| {
                if !stop.is_set() {
                    let first = number * CHUNK;
                    ask(rays.rays(first..first + answers.len(), gathered), answers);
                }
            },
        ),
    })
}

/// The same of a picture with rows of so many pixels.
fn by_tiles<S: Scalar, A: Copy + Send + Sync>(
    rays: &Source<'_, S>,
    width: usize,
    (answers, none): (&mut [A], A),
    ask: &(impl Fn(&[RayOf<S>], &mut [A]) + Sync),
    stop: &Stop,
) {
    let whole = Band::new(width, rays.count);
    answers.par_chunks_mut(whole.len()).enumerate().for_each_init(
        || (Vec::new(), Vec::new()),
        |(gathered, found), (number, answers)| {
            let (first, band) = (number * whole.len(), whole.within(answers.len()));
            for block in band.blocks() {
                if stop.is_set() {
                    return;
                }
                block.gather((rays, first), gathered);
                block.prefetch_next((rays, first));
                found.resize(gathered.len(), none);
                ask(gathered, found);
                block.scatter(found, answers);
            }
            let cut = first + band.len()..first + answers.len();
            ask(rays.rays(cut, gathered), &mut answers[band.len()..]);
        },
    );
}
