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
}
