//! A pipeline for data of any length. At any time, it reads one batch, processes one batch per
//! thread, and writes one batch.
//!
//! ```text
//!              ┌──► work ──┐
//!     ┌──► read ──► work ──┴► in order ──► write ──┐
//!     └────────────────────────────────────────────┘
//! ```
//!
//! A fixed number of batches circulates, and each batch keeps its memory, so memory use does not
//! depend on the length of the data.

use std::collections::BTreeMap;
use std::panic::{self, AssertUnwindSafe};
use std::sync::atomic::{AtomicBool, Ordering::Relaxed};
use std::sync::mpsc::{Receiver, Sender, channel};
use std::thread::{self, ScopedJoinHandle};

use crate::error::{Error, Result};

/// Circulates `batches` until `read`, which fills a batch, reaches the end of the input. The thread
/// pool runs `work` on each batch, and `write` receives all batches in the order in which they were
/// read.
///
/// The first error ends the run, but the batches before the failed one are still written.
pub(crate) fn run<B: Send>(
    batches: impl IntoIterator<Item = B>,
    read: impl FnMut(&mut B) -> Result<bool> + Send,
    work: impl Fn(&mut B) -> Result<()> + Sync,
    write: impl FnMut(&B) -> Result<()> + Send,
) -> Result<()> {
    let (free, to_read) = channel();
    let (full, to_work) = channel();
    let (done, to_write) = channel();
    for batch in batches {
        // The receiver exists, so this cannot fail.
        let _ = free.send(batch);
    }
    // When a stage ends, it drops its ends of the channels, which also ends its neighbours.
    thread::scope(|scope| {
        let start = thread::Builder::new;
        // Start the reader last, because it may wait for its input for a long time.
        let writer = start().spawn_scoped(scope, move || write_in_order(to_write, &free, write));
        let writer = writer.map_err(Error::no_thread)?;
        let reader = start().spawn_scoped(scope, move || read_all(to_read, &full, read));
        let reader = reader.map_err(Error::no_thread)?;
        work_on_all(to_work, &done, &work);
        // No more batches will be processed, so the writer may end.
        drop(done);
        let end = |thread: ScopedJoinHandle<'_, Result<()>>| unpanicked(thread.join());
        end(reader).and(end(writer))
    })
}

/// Fills free batches and passes them to the workers.
fn read_all<B>(
    free: Receiver<B>,
    full: &Sender<B>,
    mut read: impl FnMut(&mut B) -> Result<bool>,
) -> Result<()> {
    for mut batch in free {
        if !read(&mut batch)? || full.send(batch).is_err() {
            break;
        }
    }
    Ok(())
}

/// A batch number with the processed batch, or with its worker's error or panic.
type ProcessedBatch<B> = (usize, thread::Result<Result<B>>);

/// Lets the thread pool process batches until there are no more, or until the receiver is gone.
fn work_on_all<B: Send>(
    full: Receiver<B>,
    done: &Sender<ProcessedBatch<B>>,
    work: &(impl Fn(&mut B) -> Result<()> + Sync),
) {
    let refused = AtomicBool::new(false);
    rayon::in_place_scope(|threads| {
        for (number, mut batch) in full.into_iter().enumerate() {
            if refused.load(Relaxed) {
                break;
            }
            let (done, refused) = (done.clone(), &refused);
            threads.spawn(move |_| {
                // The writer waits for this batch, so it must also receive an error or a panic.
                let worked = panic::catch_unwind(AssertUnwindSafe(|| work(&mut batch)));
                if done.send((number, worked.map(|done| done.map(|()| batch)))).is_err() {
                    refused.store(true, Relaxed);
                }
            });
        }
    });
}

/// Writes batches in the order of their numbers, and frees them.
fn write_in_order<B>(
    done: Receiver<ProcessedBatch<B>>,
    free: &Sender<B>,
    mut write: impl FnMut(&B) -> Result<()>,
) -> Result<()> {
    // Batches that are finished early wait here for their turn.
    let (mut early, mut next) = (BTreeMap::new(), 0);
    for (number, worked) in done {
        early.insert(number, worked);
        while let Some(worked) = early.remove(&next) {
            let batch: B = unpanicked(worked)?;
            write(&batch)?;
            // At the end of the input, the reader no longer exists, so sending may fail.
            let _ = free.send(batch);
            next += 1;
        }
    }
    Ok(())
}

/// Returns the result of a thread, or resumes its panic.
fn unpanicked<T>(made: thread::Result<T>) -> T {
    made.unwrap_or_else(|panic| panic::resume_unwind(panic))
}

#[cfg(test)]
mod tests {
    use std::time::Duration;

    use super::*;

    /// Doubles the numbers from 0 on, with an optional failure in each stage.
    fn doubled(count: u32, fails: u32, unworked: u32, refused: u32) -> (Result<()>, Vec<u32>) {
        let (mut next, mut out) = (0..count, vec![]);
        let result = run(
            [0; 8],
            |number| {
                let Some(some) = next.next() else { return Ok(false) };
                *number = some;
                if some == fails { Err(Error::new("cannot read")) } else { Ok(true) }
            },
            |number| {
                // Some batches take longer than those after them.
                if *number % 7 == 0 {
                    thread::sleep(Duration::from_micros(200));
                }
                *number *= 2;
                if *number == unworked { Err(Error::new("cannot work")) } else { Ok(()) }
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
        let (result, out) = doubled(1000, u32::MAX, u32::MAX, u32::MAX);
        assert!(result.is_ok() && out == evens(1000));
        let (result, out) = doubled(0, u32::MAX, u32::MAX, u32::MAX);
        assert!(result.is_ok() && out.is_empty());

        // The batches before the failed one are still written.
        let (result, out) = doubled(1000, 700, u32::MAX, u32::MAX);
        assert!(format!("{result:?}").contains("cannot read") && out == evens(700));
        let (result, out) = doubled(1000, u32::MAX, 1400, u32::MAX);
        assert!(format!("{result:?}").contains("cannot work") && out == evens(700));

        let (result, out) = doubled(1000, u32::MAX, u32::MAX, 1400);
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
        let work = |number: &mut u32| {
            assert_ne!(*number, 700, "this worker panics on purpose");
            Ok(())
        };
        let whole = AssertUnwindSafe(|| run([0; 8], read, work, |_| Ok(())));
        assert!(panic::catch_unwind(whole).is_err());
    }
}
