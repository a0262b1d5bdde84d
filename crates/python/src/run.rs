//! Work on all threads without the interpreter's lock, and an ear for Ctrl-C.

use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{RecvTimeoutError, channel};
use std::thread;
use std::time::Duration;

use pyo3::prelude::*;
use rayon::ThreadPool;

/// Work of fewer items is over before anyone could press a key.
const SHORT: usize = 1 << 16;

/// How often the interpreter is asked whether a signal came.
const EAR: Duration = Duration::from_millis(20);

/// Whether work should end early.
#[derive(Default)]
pub(crate) struct Stop(AtomicBool);

impl Stop {
    pub(crate) fn is_set(&self) -> bool {
        self.0.load(Ordering::Relaxed)
    }
}

/// Does work over so many items on the threads of a pool. Where it is long, signals are heeded: what their
/// handler raises, `KeyboardInterrupt` for Ctrl-C, is the error, and the work is told to stop.
pub(crate) fn run<T: Send>(
    py: Python<'_>,
    pool: &ThreadPool,
    items: usize,
    work: impl FnOnce(&Stop) -> T + Send,
) -> PyResult<T> {
    let stop = Stop::default();
    if items <= SHORT {
        return Ok(py.detach(|| pool.install(|| work(&stop))));
    }
    py.detach(|| {
        thread::scope(|scope| {
            let (done, is_done) = channel::<()>();
            let stop = &stop;
            let worker = scope.spawn(move || {
                // Dropped, however the work ends.
                let _done = done;
                pool.install(|| work(stop))
            });
            let mut raised = Ok(());
            while is_done.recv_timeout(EAR) == Err(RecvTimeoutError::Timeout) {
                if raised.is_ok() {
                    raised = Python::attach(|py| py.check_signals());
                    stop.0.store(raised.is_err(), Ordering::Relaxed);
                }
            }
            let result = worker.join().unwrap_or_else(|panic| std::panic::resume_unwind(panic));
            raised.map(|()| result)
        })
    })
}
