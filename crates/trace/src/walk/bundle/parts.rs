//! Splits a bundle that takes too much work into parts, which may be split again.

use super::projection::{GROUPS, PACKETS};

/// The widths of parts, in packets. A bundle that takes too much work is split into parts of the
/// second width, and each of these into parts of the third width.
pub(super) const WIDTHS: [usize; 3] = [PACKETS, 16, 4];

/// A part is split once it has taken this many packet tests per ray.
const SPLIT: usize = 8;

/// After this much work per ray, the traversal abandons one of the smallest parts, because its rays
/// have too little in common. For any-hit queries, the limit is a quarter of this value, because
/// tracing the rays without a bundle then also takes less work.
const PATIENCE: usize = 32;

/// Returns the maximum amount of work for a part at a level.
#[inline(always)]
pub(super) fn budget(level: usize, any: bool) -> usize {
    let patience = if any { PATIENCE / 4 } else { PATIENCE };
    let a_ray = if level + 1 < WIDTHS.len() { SPLIT } else { patience };
    a_ray * 16 * WIDTHS[level]
}

/// The waiting parts of a bundle, the smaller ones first. The capacity is enough for all parts of
/// the smaller widths.
#[derive(Default)]
pub(super) struct WaitingParts {
    parts: [(u64, usize); 2 * (WIDTHS.len() - 1) * GROUPS],
    len: usize,
}

impl WaitingParts {
    /// Splits a part into smaller parts and adds them to the waiting parts.
    pub(super) fn add(&mut self, part: u64, level: usize) {
        let width = WIDTHS[level];
        // Add the parts in reverse order, because the part added last is taken first.
        for first in (0..PACKETS).step_by(width).rev() {
            let smaller = part & (u64::MAX >> (PACKETS - width)) << first;
            if smaller != 0 {
                self.parts[self.len] = (smaller, level);
                self.len += 1;
            }
        }
    }

    /// Returns the next part that has live packets: a mask of these packets, and the part's level.
    pub(super) fn next(&mut self, alive: u64) -> Option<(u64, usize)> {
        loop {
            self.len = self.len.checked_sub(1)?;
            let (part, level) = self.parts[self.len];
            if part & alive != 0 {
                return Some((part & alive, level));
            }
        }
    }
}
