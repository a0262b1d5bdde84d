//! The two ways to distribute work over all threads; without `parallel`, it runs sequentially.

/// `work(i)` for every `i < count`, in the order of i.
pub(crate) fn map<R: Send>(count: usize, work: impl Fn(usize) -> R + Sync + Send) -> Vec<R> {
    #[cfg(feature = "parallel")]
    {
        use rayon::prelude::*;
        (0..count).into_par_iter().map(work).collect()
    }
    #[cfg(not(feature = "parallel"))]
    (0..count).map(work).collect()
}

/// `work(i, part, scratch)` for the i-th `length` elements of `all`; the last part may be shorter. A scratch
/// is reused from part to part.
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
