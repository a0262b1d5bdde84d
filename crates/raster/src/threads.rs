//! Distributes work over all threads. Without the `parallel` feature, the work runs sequentially on
//! the calling thread.

/// Calls `work(i)` for every `i < count` and returns the results in order.
pub(crate) fn map<R: Send>(count: usize, work: impl Fn(usize) -> R + Sync + Send) -> Vec<R> {
    #[cfg(feature = "parallel")]
    {
        use rayon::prelude::*;
        (0..count).into_par_iter().map(work).collect()
    }
    #[cfg(not(feature = "parallel"))]
    (0..count).map(work).collect()
}

/// Calls `work(i, part, scratch)` for each part of `all`. A part has `length` elements, except that
/// the last part may be shorter. Each scratch value is reused for several parts.
pub(crate) fn parts<T: Send, S: Default>(
    all: &mut [T],
    length: usize,
    work: impl Fn(usize, &mut [T], &mut S) + Sync + Send,
) {
    #[cfg(feature = "parallel")]
    {
        use rayon::prelude::*;
        all.par_chunks_mut(length)
            .enumerate()
            .for_each_init(S::default, |scratch, (i, part)| work(i, part, scratch));
    }
    #[cfg(not(feature = "parallel"))]
    {
        let mut scratch = S::default();
        for (i, part) in all.chunks_mut(length).enumerate() {
            work(i, part, &mut scratch);
        }
    }
}
