//! The parts of a bundle: what is too much work for one goes on in smaller ones.

use super::projection::{GROUPS, PACKETS};

/// A bundle that is too much work goes on in parts of this many packets, and those in smaller ones.
pub(super) const WIDTHS: [usize; 3] = [PACKETS, 16, 4];

/// So much work a ray, in tests of a packet, and a part is split.
const SPLIT: usize = 8;

/// So much, and one of the smallest parts is given up: its rays have too little in common. A quarter of it for any-hit
/// queries, which a single ray answers sooner, too.
const PATIENCE: usize = 32;

/// How much work a part may take, at the level of its width.
#[inline(always)]
pub(super) fn budget(level: usize, any: bool) -> usize {
    let patience = if any { PATIENCE / 4 } else { PATIENCE };
    let a_ray = if level + 1 < WIDTHS.len() { SPLIT } else { patience };
    a_ray * 16 * WIDTHS[level]
}

/// The parts of a bundle that wait, the smaller ones first: at most all of the smallest kinds.
#[derive(Default)]
pub(super) struct Waiting {
    parts: [(u64, usize); 2 * (WIDTHS.len() - 1) * GROUPS],
    len: usize,
}

impl Waiting {
    /// Adds what a part consists of, at the level of the smaller ones.
    pub(super) fn add(&mut self, part: u64, level: usize) {
        let width = WIDTHS[level];
        // In reverse, as the last one added is the next to go on.
        for first in (0..PACKETS).step_by(width).rev() {
            let smaller = part & (u64::MAX >> (PACKETS - width)) << first;
            if smaller != 0 {
                self.parts[self.len] = (smaller, level);
                self.len += 1;
            }
        }
    }

    /// The next part with live packets: those, and its level.
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
