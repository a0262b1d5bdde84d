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
