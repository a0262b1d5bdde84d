//! Lets a caller cancel work at any time: the work occasionally checks a token, and unwinds if the
//! token requests cancellation.
//!
//! ```text
//!   StopToken::run ──► work ──► in_parallel, join ──► the token is passed to other threads
//!                                  │
//!                                  ▼
//!                           check, heed ──► unwind with Stopped if requested
//! ```

use std::cell::{Cell, RefCell};
use std::panic::resume_unwind;
use std::sync::Arc;

/// A function that returns whether to cancel the work.
type ShouldStop = Arc<dyn Fn() -> bool + Send + Sync>;

std::thread_local! {
    static CURRENT: RefCell<StopToken> = const { RefCell::new(StopToken(None)) };
    static TURNS: Cell<u32> = const { Cell::new(0) };
}

/// [`heed`] calls [`check`] once per this many calls.
const EVERY: u32 = 32;

/// The panic payload of cancelled work.
#[derive(Debug)]
pub struct Stopped;

/// A token that can cancel the work that runs under it. A token without a function cancels nothing.
#[derive(Clone, Default)]
pub struct StopToken(Option<ShouldStop>);

impl StopToken {
    /// Creates a token that cancels work as soon as `should_stop` returns true. Any worker thread
    /// may call the function, about ten thousand times per second.
    pub fn new(should_stop: Arc<dyn Fn() -> bool + Send + Sync>) -> Self {
        Self(Some(should_stop))
    }

    /// Returns the token under which this thread runs.
    pub fn current() -> Self {
        CURRENT.with_borrow(Clone::clone)
    }

    /// Runs work under this token. If the token cancels the work, the work unwinds with
    /// [`Stopped`], and no panic is reported.
    pub fn run<T>(&self, work: impl FnOnce() -> T) -> T {
        struct Before(StopToken);
        impl Drop for Before {
            fn drop(&mut self) {
                CURRENT.set(std::mem::take(&mut self.0));
            }
        }
        // The guard restores the caller's token when dropped, even if the work unwinds.
        let _before = Before(CURRENT.replace(self.clone()));
        work()
    }
}

/// Unwinds if this thread's work has been cancelled.
pub(crate) fn check() {
    let should_stop = CURRENT.with_borrow(|token| token.0.as_ref().is_some_and(|stop| stop()));
    if should_stop {
        // Unlike `panic!`, this does not call the panic hook, so nothing is printed.
        resume_unwind(Box::new(Stopped));
    }
}

/// Like [`check()`], but for inner loops: it checks only occasionally.
#[inline]
pub(crate) fn heed() {
    // A thread-local counter is cheap enough for inner loops.
    let turns = TURNS.get().wrapping_add(1);
    TURNS.set(turns);
    if turns.is_multiple_of(EVERY) {
        check();
    }
}

#[cfg(test)]
mod tests {
    use std::panic::{AssertUnwindSafe, catch_unwind};
    use std::sync::atomic::{AtomicUsize, Ordering};

    use super::*;
    use crate::util::threads;

    /// Returns the number of pieces completed under a token that cancels work the `stop_after`-th
    /// time it is checked, and whether the work was cancelled.
    fn pieces_done(stop_after: usize, pieces: usize) -> (usize, bool) {
        let (asked, done) = (Arc::new(AtomicUsize::new(0)), AtomicUsize::new(0));
        let should_stop = move || asked.fetch_add(1, Ordering::Relaxed) >= stop_after;
        let work = || {
            StopToken::new(Arc::new(should_stop)).run(|| {
                threads::pieces(0..pieces, |_, _| {
                    done.fetch_add(1, Ordering::Relaxed);
                });
            });
        };
        let ended = catch_unwind(AssertUnwindSafe(work));
        let is_stopped = ended.is_err_and(|payload| payload.is::<Stopped>());
        (done.into_inner(), is_stopped)
    }

    #[test]
    fn work_stops_on_all_threads() {
        let (done, is_stopped) = pieces_done(100, 100_000);
        assert!(is_stopped && done < 50_000, "{done}");
        assert_eq!(threads::on_this_thread(|| pieces_done(100, 100_000)), (100, true));
        assert_eq!(pieces_done(usize::MAX, 1000), (1000, false));
    }

    #[test]
    fn a_token_ends_with_its_work() {
        let stop = StopToken::new(Arc::new(|| true));
        assert!(catch_unwind(AssertUnwindSafe(|| stop.run(check))).is_err());
        check();
        stop.run(|| StopToken::default().run(check));
        let heeded =
            catch_unwind(AssertUnwindSafe(|| stop.run(|| (0..EVERY).for_each(|_| heed()))));
        assert!(heeded.is_err_and(|payload| payload.is::<Stopped>()));
    }
}
