//! Runs work on all threads, or on the calling thread if the `parallel` feature is disabled.
//!
//! A single function distributes all work in pieces, so this code is compiled only once:
//!
//! ```text
//!   each, extend, write, update, fill, all ──► pieces ──► in_parallel ──► rayon
//! ```

use std::cell::Cell;
use std::sync::Mutex;
use std::sync::atomic::{AtomicBool, Ordering};

use bytemuck::Zeroable;

use super::stop;
#[cfg(feature = "parallel")]
use super::stop::StopToken;
use crate::util::memory::{NoMemory, zeros};

/// The number of pieces per thread, chosen large enough for all threads to finish at about the same
/// time.
const PIECES: usize = 8;

std::thread_local! {
    /// Whether this thread does all work by itself, without the pool.
    static IS_ALONE: Cell<bool> = const { Cell::new(false) };
}

/// Runs work on this thread only, without starting or waking any pool thread.
pub fn on_this_thread<T>(work: impl FnOnce() -> T) -> T {
    struct Before(bool);
    impl Drop for Before {
        fn drop(&mut self) {
            IS_ALONE.set(self.0);
        }
    }
    // The guard restores the flag when dropped, so that the change does not outlast a panic.
    let _before = Before(IS_ALONE.replace(true));
    work()
}

/// Calls a function for each index in `0..count`, using all threads.
fn in_parallel(count: usize, each: &(dyn Fn(usize) + Sync)) {
    #[cfg(feature = "parallel")]
    if !IS_ALONE.get() {
        use rayon::prelude::*;
        // Pool threads do not have the caller's token, so pass it along with each piece.
        let token = StopToken::current();
        (0..count).into_par_iter().for_each(|i| {
            token.run(|| {
                stop::check();
                each(i);
            });
        });
        return;
    }
    (0..count).for_each(|i| {
        stop::check();
        each(i);
    });
}

/// Calls a function for each piece and its index, using all threads.
pub(crate) fn pieces<P: Send>(pieces: impl Iterator<Item = P>, each: impl Fn(usize, P) + Sync) {
    // The first thread that reaches a piece takes it out, so each piece is processed once.
    let all: Vec<Mutex<Option<P>>> = pieces.map(|piece| Mutex::new(Some(piece))).collect();
    in_parallel(all.len(), &|i| {
        let piece = all[i].lock().ok().and_then(|mut piece| piece.take());
        if let Some(piece) = piece {
            each(i, piece);
        }
    });
}

/// Returns the size of pieces, at least `least`, into which to split `count` items.
pub(crate) fn piece_of(count: usize, least: usize) -> usize {
    count.div_ceil(PIECES * self::count()).max(least)
}

/// Collects the results of a function for `0..count`, using all threads.
pub(crate) fn each<T: Zeroable + Send>(
    count: usize,
    of: impl Fn(usize) -> T + Sync,
) -> Result<Vec<T>, NoMemory> {
    let mut all = zeros(count)?.into_vec();
    // Compute at least 512 results per piece, so that the cost of scheduling a piece is
    // comparatively small.
    write(&mut all, 1 << 9, of);
    Ok(all)
}

/// Appends the results of a function for `0..count`, using all threads. Each piece computes at
/// least `least` results.
pub(crate) fn extend<T: Zeroable + Clone + Send>(
    all: &mut Vec<T>,
    count: usize,
    least: usize,
    of: impl Fn(usize) -> T + Sync,
) -> Result<(), NoMemory> {
    // Reserve memory first, so that a failure is reported; `resize` would abort the program.
    all.try_reserve(count)?;
    let done = all.len();
    all.resize(done + count, T::zeroed());
    write(&mut all[done..], least, of);
    Ok(())
}

/// Writes the results of a function to a slice, using all threads. Each piece computes at least
/// `least` results.
pub(crate) fn write<T: Send>(all: &mut [T], least: usize, of: impl Fn(usize) -> T + Sync) {
    let size = piece_of(all.len(), least);
    pieces(all.chunks_mut(size), |piece, all| {
        for (i, to) in all.iter_mut().enumerate() {
            *to = of(piece * size + i);
        }
    });
}

/// Calls a function that modifies each item, using all threads, and returns the function's results.
pub(crate) fn update<T: Send, R: Zeroable + Send>(
    all: &mut [T],
    change: impl Fn(&mut T) -> R + Sync,
) -> Result<Vec<R>, NoMemory> {
    let mut told = zeros(all.len())?.into_vec();
    let size = piece_of(all.len(), 1 << 7);
    pieces(all.chunks_mut(size).zip(told.chunks_mut(size)), |_, (all, told)| {
        for (one, told) in all.iter_mut().zip(told) {
            *told = change(one);
        }
    });
    Ok(told)
}

/// Fills a slice piece by piece, using all threads. If several pieces fail, returns one of the
/// errors.
#[cfg(unix)]
pub(crate) fn fill<E: Send>(
    all: &mut [u8],
    piece: usize,
    fill: impl Fn(usize, &mut [u8]) -> Result<(), E> + Sync,
) -> Result<(), E> {
    let failed = Mutex::new(Ok(()));
    pieces(all.chunks_mut(piece), |i, to| {
        if let (Err(error), Ok(mut failed)) = (fill(i, to), failed.lock()) {
            *failed = Err(error);
        }
    });
    failed.into_inner().unwrap_or(Ok(()))
}

/// Returns whether a predicate holds for all items, using all threads.
pub(crate) fn all<T: Sync>(of: &[T], holds: impl Fn(&T) -> bool + Sync) -> bool {
    let all = AtomicBool::new(true);
    pieces(of.chunks(piece_of(of.len(), 1 << 9)), |_, of| {
        // Once a piece has failed, the remaining pieces need no check.
        if all.load(Ordering::Relaxed) && !of.iter().all(&holds) {
            all.store(false, Ordering::Relaxed);
        }
    });
    all.into_inner()
}

/// Returns the number of threads.
pub(crate) fn count() -> usize {
    #[cfg(feature = "parallel")]
    if !IS_ALONE.get() {
        return rayon::current_num_threads();
    }
    1
}

/// Runs both functions, in parallel if there are several threads.
pub(crate) fn join<A: Send, B: Send>(
    a: impl FnOnce() -> A + Send,
    b: impl FnOnce() -> B + Send,
) -> (A, B) {
    stop::check();
    #[cfg(feature = "parallel")]
    if !IS_ALONE.get() {
        let token = StopToken::current();
        return rayon::join(|| token.run(a), || token.run(b));
    }
    (a(), b())
}
