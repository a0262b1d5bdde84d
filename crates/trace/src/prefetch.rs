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

/// Those rays that are not prefetched yet.
pub(crate) struct Prefetch<'a> {
    rays: &'a [Ray],
}

impl<'a> Prefetch<'a> {
    /// Of the rays that come next, so many.
    pub(crate) fn of(next: &'a [Ray], most: usize) -> Self {
        Self { rays: &next[..next.len().min(most)] }
    }

    /// Prefetches some cache lines.
    #[inline(always)]
    pub(crate) fn lines(&mut self, lines: usize) {
        for _ in 0..lines {
            if let Some((line, rest)) = self.rays.split_at_checked(64 / size_of::<Ray>()) {
                prefetch_early(line);
                self.rays = rest;
            }
        }
    }
}
