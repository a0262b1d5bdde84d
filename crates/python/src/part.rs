//! The lists of answers of some rays.

/// The lists of some rays: how many answers each has, and all of them.
pub(crate) struct Part<A> {
    pub(crate) counts: Vec<u32>,
    pub(crate) answers: Vec<A>,
}

impl<A> Part<A> {
    pub(crate) fn new() -> Self {
        Self { counts: Vec::new(), answers: Vec::new() }
    }

    /// Where the answers of each ray begin, and after the last where they end.
    pub(crate) fn begins(&self) -> Vec<usize> {
        let ends = self.counts.iter().scan(0, |end, &count| {
            *end += count as usize;
            Some(*end)
        });
        std::iter::once(0).chain(ends).collect()
    }
}
