//! The parts of a bundle: if one takes too much work, it is split into smaller ones.

use super::projection::{GROUPS, PACKETS};

/// A bundle that takes too much work is split into parts of this many packets, and those into smaller ones.
pub(super) const WIDTHS: [usize; 3] = [PACKETS, 16, 4];

/// A part is split once it takes this much work per ray, in packet tests.
const SPLIT: usize = 8;

/// One of the smallest parts is given up after this much work, because its rays have too little in common. A
/// quarter of it for any-hit queries, which single rays also answer sooner.
const PATIENCE: usize = 32;

/// How much work a part may take, at the level of its width.
#[inline(always)]
pub(super) fn budget(level: usize, any: bool) -> usize {
    let patience = if any { PATIENCE / 4 } else { PATIENCE };
    let a_ray = if level + 1 < WIDTHS.len() { SPLIT } else { patience };
    a_ray * 16 * WIDTHS[level]
}

/// The waiting parts of a bundle, the smaller ones first: at most all of the smallest kinds.
#[derive(Default)]
pub(super) struct Waiting {
    parts: [(u64, usize); 2 * (WIDTHS.len() - 1) * GROUPS],
    len: usize,
}

impl Waiting {
    /// Adds the smaller parts that make up a part.
    pub(super) fn add(&mut self, part: u64, level: usize) {
        let width = WIDTHS[level];
        // In reverse, because the last one added continues next.
        for first in (0..PACKETS).step_by(width).rev() {
            let smaller = part & (u64::MAX >> (PACKETS - width)) << first;
            if smaller != 0 {
                self.parts[self.len] = (smaller, level);
                self.len += 1;
            }
        }
    }

    /// The next part with live packets: these packets, and its level.
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
