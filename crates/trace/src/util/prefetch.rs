//! Prefetches the next rays while the current ones are traced.
//!
//! ```text
//!   a bundle      project ▪▪▪▪▪▪▪▪  list ▪▪▪▪▪  test ▪▪▪▪▪▪▪▪▪▪     next bundle, already cached
//!   cache lines          | | | | |      | | |       |  |  |
//! ```
//!
//! A core can have only one or two dozen cache misses in flight. Prefetching all 512 cache lines of
//! a bundle at once would stall it, but prefetching a line now and then costs almost nothing.

use intertri::Ray;
use intertri::internal::prefetch_early;

/// The part of the upcoming rays' memory that is still to be prefetched.
pub(crate) struct Prefetch<'a> {
    memory: &'a [u8],
    /// The number of cache lines to prefetch per cache line of f32 rays.
    times: usize,
}

impl<'a> Prefetch<'a> {
    /// Prepares to prefetch the memory of the next `rays` rays, or of all remaining rays if there
    /// are fewer.
    pub(crate) fn of(memory: &'a [u8], rays: usize) -> Self {
        Self { memory, times: memory.len().div_ceil((rays * size_of::<Ray>()).max(1)) }
    }

    /// Prefetches the next cache lines.
    #[inline(always)]
    pub(crate) fn lines(&mut self, lines: usize) {
        for _ in 0..lines * self.times {
            // Prefetch a whole cache line. A partial line at the end is not worth prefetching.
            if let Some((line, rest)) = self.memory.split_at_checked(64) {
                prefetch_early(line);
                self.memory = rest;
            }
        }
    }
}
