//! Prefetches the next rays while others are traced.
//!
//! ```text
//!   a bundle      project ▪▪▪▪▪▪▪▪  list ▪▪▪▪▪  test ▪▪▪▪▪▪▪▪▪▪     the next bundle: its rays are cached
//!   cache lines          | | | | |      | | |       |  |  |
//! ```
//!
//! A core can have one or two dozen cache misses in flight. Prefetching a bundle's 512 lines at once would
//! stall it; one line now and then costs almost nothing.

use intertri::Ray;
use intertri::internal::prefetch_early;

/// The part of the next rays' memory that has not been prefetched yet.
pub(crate) struct Prefetch<'a> {
    memory: &'a [u8],
    /// Cache lines to prefetch for each line of rays in f32.
    times: usize,
}

impl<'a> Prefetch<'a> {
    /// The memory of the next `rays` rays, or fewer.
    pub(crate) fn of(memory: &'a [u8], rays: usize) -> Self {
        Self { memory, times: memory.len().div_ceil((rays * size_of::<Ray>()).max(1)) }
    }

    /// Prefetches some cache lines.
    #[inline(always)]
    pub(crate) fn lines(&mut self, lines: usize) {
        for _ in 0..lines * self.times {
            // One cache line. The rest at the end is shorter and not worth it.
            if let Some((line, rest)) = self.memory.split_at_checked(64) {
                prefetch_early(line);
                self.memory = rest;
            }
        }
    }
}
