//! Child prediction: guesses that a ray visits the same child of a node as the previous ray did.
//!
//! ```text
//!   node ──► its eight boxes are tested ──► the nearest box hit           about 40 cycles per node
//!    └─────► where the last ray went ──► a guess, at once. The CPU continues with it and finds out
//!                                        later, past a predicted branch, whether it was right.
//! ```
//!
//! A guess never affects the result: the child returned is always the one that the box tests chose.
//! Ray streams need no guesses, because other rays are tested while one ray waits.

/// The number of guesses kept. Nodes whose indices are equal modulo this number share an entry.
const NODES: usize = 1024;

/// The guesses, which belong to one hierarchy at a time.
#[derive(Debug)]
pub(crate) struct ChildPredictor {
    /// For each node, two copies of the child that the last ray visited. One copy is compared, and
    /// the other is returned. If the compiler knew that they are equal, it would return the value
    /// that was compared.
    last: [[u32; 2]; NODES],
}

impl Default for ChildPredictor {
    fn default() -> Self {
        Self { last: [[0; 2]; NODES] }
    }
}

impl ChildPredictor {
    /// Returns `next`, the child that a ray visits from a node.
    #[inline(always)]
    pub(crate) fn follow(&mut self, node: u32, next: u32) -> u32 {
        let last = &mut self.last[node as usize % NODES];
        // Both copies load from memory immediately. `next` arrives only after the box tests, but
        // the branch on the comparison is predicted.
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

    /// Guesses must not change the result, whether they are right or wrong, and whether they were
    /// made for the same node or for one that shares its entry.
    #[test]
    fn what_is_given_is_what_was_asked_for() {
        let mut predictor = ChildPredictor::default();
        for i in 0..10_000_u32 {
            let (node, next) = (i * i % 31 * NODES as u32 / 4, i / 100 % 3 + i % 17 / 16);
            assert_eq!(predictor.follow(node, next), next);
        }
    }
}
