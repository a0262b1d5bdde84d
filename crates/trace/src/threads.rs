//! Work on all threads where there are threads.

use crate::memory::{NoMemory, room};

/// What a function gives for 0 to `count`, on all threads where there are threads.
#[cfg(feature = "parallel")]
pub(crate) fn each<T: Send>(
    count: usize,
    of: impl Fn(usize) -> T + Sync + Send,
) -> Result<Vec<T>, NoMemory> {
    use rayon::prelude::*;
    let mut all = room(count)?;
    (0..count).into_par_iter().with_min_len(1 << 9).map(of).collect_into_vec(&mut all);
    Ok(all)
}

#[cfg(not(feature = "parallel"))]
pub(crate) fn each<T>(count: usize, of: impl Fn(usize) -> T) -> Result<Vec<T>, NoMemory> {
    let mut all = room(count)?;
    all.extend((0..count).map(of));
    Ok(all)
}

/// Appends what a function gives for 0 to `count`, on all threads where there are threads; each does at least
/// `least` in a row.
#[cfg(feature = "parallel")]
pub(crate) fn extend<T: Send>(
    all: &mut Vec<T>,
    count: usize,
    least: usize,
    of: impl Fn(usize) -> T + Sync + Send,
) -> Result<(), NoMemory> {
    use rayon::prelude::*;
    all.try_reserve(count)?;
    all.par_extend((0..count).into_par_iter().with_min_len(least).map(of));
    Ok(())
}

#[cfg(not(feature = "parallel"))]
pub(crate) fn extend<T>(
    all: &mut Vec<T>,
    count: usize,
    _least: usize,
    of: impl Fn(usize) -> T,
) -> Result<(), NoMemory> {
    all.try_reserve(count)?;
    all.extend((0..count).map(of));
    Ok(())
}

/// Changes all, on all threads where there are threads, and gives what that tells.
pub(crate) fn update<T: Send, R: Send>(
    all: &mut [T],
    change: impl Fn(&mut T) -> R + Sync + Send,
) -> Result<Vec<R>, NoMemory> {
    let mut told = room(all.len())?;
    #[cfg(feature = "parallel")]
    {
        use rayon::prelude::*;
        all.par_iter_mut().with_min_len(1 << 7).map(change).collect_into_vec(&mut told);
    }
    #[cfg(not(feature = "parallel"))]
    told.extend(all.iter_mut().map(change));
    Ok(told)
}

/// Fills pieces of a slice, on all threads where there are threads, until one fails.
#[cfg(unix)]
pub(crate) fn fill<E: Send>(
    all: &mut [u8],
    piece: usize,
    fill: impl Fn(usize, &mut [u8]) -> Result<(), E> + Sync + Send,
) -> Result<(), E> {
    #[cfg(feature = "parallel")]
    {
        use rayon::prelude::*;
        all.par_chunks_mut(piece).enumerate().try_for_each(|(i, to)| fill(i, to))
    }
    #[cfg(not(feature = "parallel"))]
    all.chunks_mut(piece).enumerate().try_for_each(|(i, to)| fill(i, to))
}

/// Whether something holds of all, on all threads where there are threads.
pub(crate) fn all<T: Sync>(of: &[T], holds: impl Fn(&T) -> bool + Sync + Send) -> bool {
    #[cfg(feature = "parallel")]
    {
        use rayon::prelude::*;
        of.par_iter().with_min_len(1 << 9).all(holds)
    }
    #[cfg(not(feature = "parallel"))]
    of.iter().all(holds)
}

/// How many threads there are.
pub(crate) fn count() -> usize {
    #[cfg(feature = "parallel")]
    return rayon::current_num_threads();
    #[cfg(not(feature = "parallel"))]
    1
}

/// Runs both, side by side where there are threads.
#[cfg(feature = "parallel")]
pub(crate) fn join<A: Send, B: Send>(
    a: impl FnOnce() -> A + Send,
    b: impl FnOnce() -> B + Send,
) -> (A, B) {
    rayon::join(a, b)
}

#[cfg(not(feature = "parallel"))]
pub(crate) fn join<A, B>(a: impl FnOnce() -> A, b: impl FnOnce() -> B) -> (A, B) {
    (a(), b())
}
