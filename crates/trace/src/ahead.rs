//! The rays that come next, asked for from memory while others are searched.
//!
//! ```text
//!   work of a tile   lay ▪▪▪▪▪▪▪▪  list ▪▪▪▪▪  test ▪▪▪▪▪▪▪▪▪▪     the next tile: its rays are there
//!   cache lines          | | | | |      | | |       |  |  |
//! ```
//!
//! A core can wait for a dozen lines or two at a time. A tile's 512 all at once would keep it waiting; one
//! here and there costs next to nothing.

use intertri::lanes::prefetch_early;

/// Those rays that are not asked for yet.
pub(crate) struct Ahead<'a, R> {
    rays: &'a [R],
}

impl<'a, R> Ahead<'a, R> {
    /// Of the rays that come next, so many.
    pub(crate) fn of(next: &'a [R], most: usize) -> Self {
        Self { rays: &next[..next.len().min(most)] }
    }

    /// Asks for some cache lines.
    #[inline(always)]
    pub(crate) fn ask(&mut self, lines: usize) {
        for _ in 0..lines {
            if let Some((line, rest)) = self.rays.split_at_checked((64 / size_of::<R>()).max(1)) {
                prefetch_early(line);
                self.rays = rest;
            }
        }
    }
}
