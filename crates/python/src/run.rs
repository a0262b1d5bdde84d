//! Runs jobs without the interpreter's lock, but lets Ctrl-C end them.

use std::ops::Range;
use std::panic::{AssertUnwindSafe, catch_unwind, resume_unwind};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{RecvTimeoutError, channel};
use std::sync::{Arc, Mutex, PoisonError};
use std::thread::Builder;
use std::time::{Duration, Instant};

use intertri_trace::internal::{StopToken, Stopped, on_this_thread};
use pyo3::exceptions::PyRuntimeError;
use pyo3::prelude::*;

use crate::pool::Workers;

/// The interval between checks for signals.
const INTERVAL: Duration = Duration::from_millis(20);

/// A request for a job to end early, made when a signal handler raises an exception.
pub(crate) struct Stop {
    is_set: AtomicBool,
    raised: Mutex<Option<PyErr>>,
    /// The time of the last check for signals, if the working thread does the checks.
    asked: Option<Mutex<Instant>>,
}

impl Stop {
    fn new(is_caller: bool) -> Self {
        let asked = is_caller.then(|| Mutex::new(Instant::now()));
        Self { is_set: AtomicBool::new(false), raised: Mutex::new(None), asked }
    }

    pub(crate) fn is_set(&self) -> bool {
        if let Some(asked) = &self.asked {
            let mut asked = asked.lock().unwrap_or_else(PoisonError::into_inner);
            if asked.elapsed() > INTERVAL {
                self.check_signals();
                *asked = Instant::now();
            }
        }
        self.is_set.load(Ordering::Relaxed)
    }

    /// Runs the handlers of pending signals. If one raises an exception, the job ends.
    fn check_signals(&self) {
        if self.is_set.load(Ordering::Relaxed) {
            return;
        }
        if let Err(error) = Python::attach(|py| py.check_signals()) {
            *self.raised.lock().unwrap_or_else(PoisonError::into_inner) = Some(error);
            self.is_set.store(true, Ordering::Relaxed);
        }
    }
}

/// Runs a job on the given threads. If a signal handler raises an exception, such as
/// `KeyboardInterrupt` for Ctrl-C, the job stops early, even in the middle of a call to
/// `intertri-trace`, and the exception is returned.
pub(crate) fn run<T: Send>(
    py: Python<'_>,
    workers: &Workers,
    work: impl FnOnce(&Stop) -> T + Send,
) -> PyResult<T> {
    let stop = Arc::new(Stop::new(matches!(workers, Workers::Caller)));
    let token = StopToken::new({
        let stop = stop.clone();
        Arc::new(move || stop.is_set())
    });
    // If a query or a build is cancelled, its thread unwinds.
    let work = || catch_unwind(AssertUnwindSafe(|| token.run(|| work(&stop))));
    let result = match workers {
        Workers::Caller => py.detach(|| Some(on_this_thread(work))),
        Workers::Pool(pool) => py.detach(|| {
            let (done, is_done) = channel::<()>();
            let mut result = None;
            pool.in_place_scope(|scope| {
                scope.spawn(|_| {
                    // Dropping `done` wakes the caller, however the job ends.
                    let _done = done;
                    result = Some(work());
                });
                while is_done.recv_timeout(INTERVAL) == Err(RecvTimeoutError::Timeout) {
                    stop.check_signals();
                }
            });
            result
        }),
    };
    let raised = stop.raised.lock().unwrap_or_else(PoisonError::into_inner).take();
    match (raised, result) {
        (_, Some(Err(panic))) if !panic.is::<Stopped>() => resume_unwind(panic),
        (Some(error), _) => Err(error),
        (None, Some(Ok(result))) => Ok(result),
        (None, _) => unreachable!("work stops early only after a signal handler raised"),
    }
}

/// Runs a job that cannot be cancelled, on a separate thread. If a signal handler raises an
/// exception, the exception is returned at once. The thread then runs to its end, and its result is
/// dropped.
pub(crate) fn run_apart<T: Send + 'static>(
    py: Python<'_>,
    work: impl FnOnce() -> T + Send + 'static,
) -> PyResult<T> {
    let (done, mut result) = channel();
    let worker = Builder::new().name("intertri".into()).spawn(move || {
        // Sending fails if the caller no longer waits.
        _ = done.send(work());
    });
    let worker = worker
        .map_err(|error| PyRuntimeError::new_err(format!("cannot start a thread: {error}")))?;
    loop {
        let waiting = &mut result;
        match py.detach(move || waiting.recv_timeout(INTERVAL)) {
            Ok(result) => return Ok(result),
            Err(RecvTimeoutError::Timeout) => py.check_signals()?,
            Err(RecvTimeoutError::Disconnected) => match worker.join() {
                Err(panic) => resume_unwind(panic),
                Ok(()) => unreachable!("the thread sends its result before it ends"),
            },
        }
    }
}

/// Processes `count` items piece by piece, until all are done or the job is cancelled. The size of
/// the pieces adapts so that each takes a few milliseconds.
pub(crate) fn pieces(count: usize, stop: &Stop, mut each: impl FnMut(Range<usize>)) {
    let (mut done, mut size) = (0, 8);
    while done < count && !stop.is_set() {
        let end = count.min(done + size);
        let began = Instant::now();
        each(done..end);
        done = end;
        size = match began.elapsed().as_millis() {
            0..=1 => 4 * size,
            2..=20 => size,
            _ => (size / 4).max(1),
        };
    }
}
