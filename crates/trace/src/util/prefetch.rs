//! The rays that come next, prefetched while others are traced.
//!
//! ```text
//!   a bundle      project ▪▪▪▪▪▪▪▪  list ▪▪▪▪▪  test ▪▪▪▪▪▪▪▪▪▪     the next bundle: its rays are there
//!   cache lines          | | | | |      | | |       |  |  |
//! ```
//!
//! A core can wait for a dozen lines or two at a time. A bundle's 512 all at once would keep it waiting; one
//! here and there costs next to nothing.

use intertri::Ray;
use intertri::internal::prefetch_early;

/// The memory of the rays that come next, as far as it is not prefetched yet.
pub(crate) struct Prefetch<'a> {
    memory: &'a [u8],
    /// Cache lines to prefetch for each line of rays in f32.
    times: usize,
}

impl<'a> Prefetch<'a> {
    /// The memory from which so many rays come next, at most.
    pub(crate) fn of(memory: &'a [u8], rays: usize) -> Self {
        Self { memory, times: memory.len().div_ceil((rays * size_of::<Ray>()).max(1)) }
    }

    /// Prefetches some cache lines.
    #[inline(always)]
    pub(crate) fn lines(&mut self, lines: usize) {
        for _ in 0..lines * self.times {
            if let Some((line, rest)) = self.memory.split_at_checked(64) {
                prefetch_early(line);
                self.memory = rest;
            }
        }
    }
}
