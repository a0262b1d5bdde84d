//! What is too long for memory, batch by batch: one is read, one is worked on and one is written, all at
//! the same time.
//!
//! ```text
//!     ┌──► read ──► work ──► write ──┐
//!     └──────────────────────────────┘
//! ```
//!
//! A few batches go round, and their memory with them, so that it stays the same however long the stream.

use std::panic;
use std::sync::mpsc::channel;
use std::thread::{self, ScopedJoinHandle};

use crate::error::Result;

/// Sends `batches` round until `read` says that there is nothing more: it fills a batch, `work` answers
/// it, in this thread, and `write` gets all batches in the order in which they were read.
///
/// The first error ends it; what was read before is still written.
pub(crate) fn stream<B: Send>(
    batches: impl IntoIterator<Item = B>,
    mut read: impl FnMut(&mut B) -> Result<bool> + Send,
    mut work: impl FnMut(&mut B),
    mut write: impl FnMut(&B) -> Result<()> + Send,
) -> Result<()> {
    let (free, to_read) = channel();
    let (full, to_work) = channel();
    let (done, to_write) = channel();
    for batch in batches {
        // Its other end is a few lines above.
        let _ = free.send(batch);
    }
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
            for batch in to_write {
                write(&batch)?;
                // At the end nobody reads any more.
                let _ = free.send(batch);
            }
            Ok(())
        });
        for mut batch in to_work {
            work(&mut batch);
            if done.send(batch).is_err() {
                break;
            }
        }
        drop(done);
        let end = |thread: ScopedJoinHandle<'_, Result<()>>| {
            thread.join().unwrap_or_else(|panic| panic::resume_unwind(panic))
        };
        end(reader).and(end(writer))
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::error::Error;

    /// Numbers from 0 are doubled.
    fn doubled(count: u32, fails: u32, refused: u32) -> (Result<()>, Vec<u32>) {
        let (mut next, mut out) = (0..count, vec![]);
        let result = stream(
            [0; 3],
            |number| {
                let Some(some) = next.next() else { return Ok(false) };
                *number = some;
                if some == fails { Err(Error::new("cannot read")) } else { Ok(true) }
            },
            |number| *number *= 2,
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
}
