//! Many rays: in chunks over the threads, each gathered from numpy's arrays into the cache and traced there.

use intertri::RayOf;
use pyo3::prelude::*;
use rayon::ThreadPool;
use rayon::prelude::*;

use crate::order::{TILE, row_width, tiled};
use crate::run::{Stop, run};
use crate::scalar::Scalar;
use crate::source::Source;

/// Rays a thread takes at a time.
const CHUNK: usize = 8192;

/// Of pictures, rays in the order of tiles that are asked together.
const TILES: usize = 4 * TILE * TILE;

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
    // So many rows that each thread has some parts.
    let parts = 4 * rayon::current_num_threads();
    let most = rays.count / width / parts / TILE;
    let part = width * TILE * most.clamp(1, 4);
    let order = tiled(width, part.min(rays.count));
    answers.par_chunks_mut(part).enumerate().for_each_init(
        || (Vec::new(), Vec::new()),
        |(gathered, found), (number, answers)| {
            let own;
            let order = if answers.len() == order.len() {
                &order
            } else {
                own = tiled(width, answers.len());
                &own
            };
            for order in order.chunks(TILES) {
                if stop.is_set() {
                    return;
                }
                rays.gather(order.iter().map(|&i| number * part + i as usize), gathered);
                found.resize(order.len(), none);
                ask(gathered, found);
                for (&i, &found) in order.iter().zip(&*found) {
                    answers[i as usize] = found;
                }
            }
        },
    );
}
