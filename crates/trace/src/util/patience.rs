//! When to try something again that did not pay.

/// Turns to wait: after each failure in a row, twice as many.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Patience {
    wait: usize,
    next: usize,
    bounds: [usize; 2],
}

impl Patience {
    /// After the first failure it waits for the first of these numbers of turns; never for more than the second.
    pub(crate) fn new(bounds: [usize; 2]) -> Self {
        Self { wait: 0, next: bounds[0], bounds }
    }

    /// Whether to wait for another turn.
    #[inline(always)]
    pub(crate) fn is_waiting(&self) -> bool {
        self.wait > 0
    }

    /// A turn passes.
    #[inline(always)]
    pub(crate) fn pass(&mut self) {
        self.wait = self.wait.saturating_sub(1);
    }

    /// It was tried.
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

    /// The number of turns to wait.
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
