//! Exponential backoff for optimizations that do not always pay off.

/// Decides when to try an optimization again. The wait doubles with each consecutive failure.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Patience {
    wait: usize,
    next: usize,
    bounds: [usize; 2],
}

impl Patience {
    /// Creates a backoff that waits `bounds[0]` turns after the first failure and at most
    /// `bounds[1]` turns after later ones.
    pub(crate) fn new(bounds: [usize; 2]) -> Self {
        Self { wait: 0, next: bounds[0], bounds }
    }

    /// Returns whether to skip this turn.
    #[inline(always)]
    pub(crate) fn is_waiting(&self) -> bool {
        self.wait > 0
    }

    /// Records that a turn was skipped.
    #[inline(always)]
    pub(crate) fn pass(&mut self) {
        self.wait = self.wait.saturating_sub(1);
    }

    /// Records an attempt and whether it paid off.
    #[inline(always)]
    pub(crate) fn tried(&mut self, has_paid: bool) {
        let [least, most] = self.bounds;
        (self.wait, self.next) =
            if has_paid { (0, least) } else { (self.next, most.min(2 * self.next)) };
    }
}

#[cfg(test)]
mod tests {
    use super::Patience;

    /// Counts the turns until the next attempt.
    fn turns(mut patience: Patience) -> usize {
        let mut turns = 0;
        while patience.is_waiting() {
            patience.pass();
            turns += 1;
        }
        turns
    }

    #[test]
    fn it_waits_twice_as_long_after_each_failure_and_begins_anew_after_a_success() {
        let mut patience = Patience::new([4, 20]);
        assert_eq!(turns(patience), 0);
        for wait in [4, 8, 16, 20, 20] {
            patience.tried(false);
            assert_eq!(turns(patience), wait);
        }
        patience.tried(true);
        assert_eq!(turns(patience), 0);
        patience.tried(false);
        assert_eq!(turns(patience), 4);
    }
}
