//! What is too long for memory, batch by batch: one is read, one a thread is worked on and one is written, all
//! at the same time.
//!
//! ```text
//!              ┌──► work ──┐
//!     ┌──► read ──► work ──┴► in order ──► write ──┐
//!     └────────────────────────────────────────────┘
//! ```
//!
//! A few batches go round, and their memory with them, so that it stays the same however long the stream.

use std::collections::BTreeMap;
use std::panic::{self, AssertUnwindSafe};
use std::sync::atomic::{AtomicBool, Ordering::Relaxed};
use std::sync::mpsc::channel;
use std::thread::{self, ScopedJoinHandle};

use crate::error::Result;

/// Bytes that a pipe is to hold: the most that a Linux as it comes lets anyone have.
#[cfg(target_os = "linux")]
const PIPE: usize = 1 << 20;

/// Sends `batches` round until `read` says that there is nothing more: it fills a batch, one of all threads
/// lets `work` answer it, and `write` gets all batches in the order in which they were read.
///
/// The first error ends it; what was read before is still written.
pub(crate) fn stream<B: Send>(
    batches: impl IntoIterator<Item = B>,
    mut read: impl FnMut(&mut B) -> Result<bool> + Send,
    work: impl Fn(&mut B) + Sync,
    mut write: impl FnMut(&B) -> Result<()> + Send,
) -> Result<()> {
    let (free, to_read) = channel();
    let (full, to_work) = channel();
    let (done, to_write) = channel();
    for batch in batches {
        // Its other end is a line above.
        let _ = free.send(batch);
    }
    let refused = AtomicBool::new(false);
    // Whoever ends drops his ends of the channels, by which his neighbours know.
    thread::scope(|scope| {
        let reader = scope.spawn(move || {
            for mut batch in to_read {
                if !read(&mut batch)? || full.send(batch).is_err() {
                    break;
                }
            }
            Ok(())
        });
        let writer = scope.spawn(move || {
            // What is done before its turn waits.
            let (mut early, mut next) = (BTreeMap::new(), 0);
            for (number, worked) in to_write {
                early.insert(number, worked);
                while let Some(worked) = early.remove(&next) {
                    let batch: B = unpanicked(worked);
                    write(&batch)?;
                    // At the end nobody reads any more.
                    let _ = free.send(batch);
                    next += 1;
                }
            }
            Ok(())
        });
        rayon::in_place_scope(|threads| {
            for (number, mut batch) in to_work.into_iter().enumerate() {
                if refused.load(Relaxed) {
                    break;
                }
                let (done, work, refused) = (done.clone(), &work, &refused);
                threads.spawn(move |_| {
                    // The writer waits for this batch, and so must hear of a panic.
                    let worked = panic::catch_unwind(AssertUnwindSafe(|| work(&mut batch)));
                    if done.send((number, worked.map(|()| batch))).is_err() {
                        refused.store(true, Relaxed);
                    }
                });
            }
        });
        drop(done);
        let end = |thread: ScopedJoinHandle<'_, Result<()>>| unpanicked(thread.join());
        end(reader).and(end(writer))
    })
}

/// What a thread made, or its panic.
fn unpanicked<T>(made: thread::Result<T>) -> T {
    made.unwrap_or_else(|panic| panic::resume_unwind(panic))
}

/// Lets the pipes at both ends, where there are some, hold as much as a batch; they hold 64 KB at first, and
/// whoever writes to one then waits for whoever reads after every few rays.
#[cfg(target_os = "linux")]
pub(crate) fn widen_pipes() {
    use std::io::{stdin, stdout};
    // What is no pipe refuses, and where there is too little room a pipe stays as it is.
    let _ = rustix::pipe::fcntl_setpipe_size(stdin(), PIPE);
    let _ = rustix::pipe::fcntl_setpipe_size(stdout(), PIPE);
}

#[cfg(not(target_os = "linux"))]
pub(crate) fn widen_pipes() {}

#[cfg(test)]
mod tests {
    use std::time::Duration;

    use super::*;
    use crate::error::Error;

    /// Numbers from 0 are doubled.
    fn doubled(count: u32, fails: u32, refused: u32) -> (Result<()>, Vec<u32>) {
        let (mut next, mut out) = (0..count, vec![]);
        let result = stream(
            [0; 8],
            |number| {
                let Some(some) = next.next() else { return Ok(false) };
                *number = some;
                if some == fails { Err(Error::new("cannot read")) } else { Ok(true) }
            },
            |number| {
                // Some take longer than those behind them.
                if *number % 7 == 0 {
                    thread::sleep(Duration::from_micros(200));
                }
                *number *= 2;
            },
            |&number| {
                if number == refused {
                    return Err(Error::new("cannot write"));
                }
                out.push(number);
                Ok(())
            },
        );
        (result, out)
    }

    #[test]
    fn batches_keep_their_order_and_errors_end_it() {
        let evens = |count: u32| (0..count).map(|i| 2 * i).collect::<Vec<_>>();
        let (result, out) = doubled(1000, u32::MAX, u32::MAX);
        assert!(result.is_ok() && out == evens(1000));
        let (result, out) = doubled(0, u32::MAX, u32::MAX);
        assert!(result.is_ok() && out.is_empty());

        // What was read before an error is written.
        let (result, out) = doubled(1000, 700, u32::MAX);
        assert!(format!("{result:?}").contains("cannot read") && out == evens(700));
        let (result, out) = doubled(1000, u32::MAX, 1400);
        assert!(format!("{result:?}").contains("cannot write") && out == evens(700));
    }

    #[test]
    fn a_panic_at_work_ends_it() {
        let mut left = 1000;
        let read = |number: &mut u32| {
            left -= 1;
            *number = left;
            Ok(left > 0)
        };
        let work = |number: &mut u32| assert_ne!(*number, 700, "is not to be liked");
        let run = AssertUnwindSafe(|| stream([0; 8], read, work, |_| Ok(())));
        assert!(panic::catch_unwind(run).is_err());
    }
}
