//! Child prediction: where rays went on to from a node, as a guess for the next ray there.
//!
//! ```text
//!   node ──► its eight boxes tested ──► the nearest that is met      some 40 cycles, node after node
//!    └─────► where the last ray went ──► a guess, at once; the CPU goes on with it, and behind a branch,
//!                                        which it predicts, finds out later whether it was right
//! ```
//!
//! A guess never decides anything: what is gone on with equals what the boxes say. Ray streams need
//! none, for others are tested while one waits.

/// Nodes whose guesses are kept; those of nodes with the same remainder take each other's place.
const NODES: usize = 1024;

/// Guesses about one hierarchy after another.
#[derive(Debug)]
pub(crate) struct ChildPredictor {
    /// By node what the last ray went on to, twice: one is compared, and the other is gone on with. The
    /// compiler must not know that they are the same, or it would go on with what they are compared with.
    last: [[u32; 2]; NODES],
}

impl Default for ChildPredictor {
    fn default() -> Self {
        Self { last: [[0; 2]; NODES] }
    }
}

impl ChildPredictor {
    /// Gives `next`, which is what a ray goes on to from a node.
    #[inline(always)]
    pub(crate) fn follow(&mut self, node: u32, next: u32) -> u32 {
        let last = &mut self.last[node as usize % NODES];
        // These come from memory at once. `next` arrives only when the boxes are tested, but the comparison is
        // predicted.
        let [guess, check] = *last;
        if next == check {
            return guess;
        }
        *last = [next; 2];
        next
    }
}

#[cfg(test)]
mod tests {
    use super::{ChildPredictor, NODES};

    /// Right or wrong, of the node or of another with the same remainder: a guess changes nothing.
    #[test]
    fn what_is_given_is_what_was_asked_for() {
        let mut predictor = ChildPredictor::default();
        for i in 0..10_000_u32 {
            let (node, next) = (i * i % 31 * NODES as u32 / 4, i / 100 % 3 + i % 17 / 16);
            assert_eq!(predictor.follow(node, next), next);
        }
    }
}
