//! A [`Part`]: the lists of answers that one thread produces for a range of rays.

use pyo3::exceptions::PyMemoryError;
use pyo3::prelude::*;

/// The lists of answers for a range of rays, stored one after another.
pub(crate) struct Part<A> {
    /// The bounds of the lists, starting at 0: ray i has the answers from `offsets[i]` to
    /// `offsets[i + 1]`.
    pub(crate) offsets: Vec<i64>,
    pub(crate) answers: Vec<A>,
}

impl<A: Copy> Part<A> {
    /// Creates a part without rays.
    pub(crate) fn new() -> Self {
        Self { offsets: vec![0], answers: Vec::new() }
    }

    /// Returns the number of rays.
    pub(crate) fn rays(&self) -> usize {
        self.offsets.len() - 1
    }

    /// Removes all rays and answers.
    pub(crate) fn clear(&mut self) {
        self.offsets.truncate(1);
        self.answers.clear();
    }

    /// Reserves memory for more rays and answers.
    pub(crate) fn reserve(&mut self, rays: usize, answers: usize) -> PyResult<()> {
        let room = self.offsets.try_reserve(rays).and_then(|()| self.answers.try_reserve(answers));
        room.map_err(|_| too_many(self.answers.len() + answers))
    }

    /// Appends the lists of `count` rays of another part, beginning with the ray `first`.
    #[inline]
    pub(crate) fn add(&mut self, other: &Self, (first, count): (usize, usize)) {
        let offsets = &other.offsets[first..=first + count];
        let (begin, end) = (offsets[0], offsets[count]);
        let moved = self.answers.len() as i64 - begin;
        self.offsets.extend(offsets[1..].iter().map(|offset| offset + moved));
        self.answers.extend_from_slice(&other.answers[begin as usize..end as usize]);
    }
}

/// Creates the error for answers that need more memory than is available.
fn too_many(answers: usize) -> PyErr {
    PyMemoryError::new_err(format!("{answers} answers need more memory than is available"))
}
