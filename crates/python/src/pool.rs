//! The threads that trace rays: the calling thread, or a pool. There is one pool for each thread
//! count.

use std::collections::HashMap;
use std::num::NonZeroUsize;
use std::sync::{Arc, Mutex, PoisonError};
use std::thread::available_parallelism;

use intertri_trace::internal::{StopToken, on_this_thread};
use pyo3::exceptions::PyRuntimeError;
use pyo3::prelude::*;
use rayon::prelude::*;
use rayon::{ThreadPool, ThreadPoolBuilder};

/// This process's pools, keyed by thread count. A forked process has none of its parent's threads,
/// so it starts without pools. A thread that holds this lock also holds the interpreter's lock, so
/// no fork can happen while `POOLS` is locked.
static POOLS: Mutex<Option<Pools>> = Mutex::new(None);

struct Pools {
    process: u32,
    by_threads: HashMap<usize, Arc<ThreadPool>>,
}

/// The threads that do the work of a call.
pub(crate) enum Workers {
    /// The calling thread. Small calls then wake no other threads, and single-threaded calls from
    /// several Python threads can run in parallel.
    Caller,
    /// The threads of a pool.
    Pool(Arc<ThreadPool>),
}

impl Workers {
    /// Uses the given number of threads, or as many as the process may run at once if `threads` is
    /// `None`. Small jobs run on the calling thread.
    pub(crate) fn new(threads: Option<NonZeroUsize>, is_small: bool) -> PyResult<Self> {
        let one = NonZeroUsize::MIN;
        if is_small || threads == Some(one) {
            return Ok(Self::Caller);
        }
        // More threads than the process can run at once would only take turns.
        let most = available_parallelism().unwrap_or(one);
        match threads.map_or(most, |threads| threads.min(most)) {
            threads if threads == one => Ok(Self::Caller),
            threads => Ok(Self::Pool(pool(threads.get())?)),
        }
    }

    /// Runs a job on the chosen threads.
    pub(crate) fn install<T: Send>(&self, work: impl FnOnce() -> T + Send) -> T {
        match self {
            Self::Caller => on_this_thread(work),
            Self::Pool(pool) => pool.install(work),
        }
    }
}

/// Returns whether the calling thread does the work.
pub(crate) fn is_caller() -> bool {
    rayon::current_thread_index().is_none()
}

/// Returns the number of threads that do the work.
pub(crate) fn workers() -> usize {
    if is_caller() { 1 } else { rayon::current_num_threads() }
}

/// Computes the answers in chunks on all workers. Each worker has its own state. `each` receives
/// the chunk's number.
pub(crate) fn chunks<A: Send, T>(
    answers: &mut [A],
    size: usize,
    state: impl Fn() -> T + Sync + Send,
    each: impl Fn(&mut T, usize, &mut [A]) + Sync + Send,
) {
    let chunks = answers.chunks_mut(size).enumerate().collect();
    distribute(chunks, state, |state, (number, answers)| each(state, number, answers));
}

/// Distributes pieces of work to all workers. Each worker has its own state.
pub(crate) fn distribute<P: Send, T>(
    pieces: Vec<P>,
    state: impl Fn() -> T + Sync + Send,
    each: impl Fn(&mut T, P) + Sync + Send,
) {
    if is_caller() {
        let mut state = state();
        for piece in pieces {
            each(&mut state, piece);
        }
    } else {
        let token = StopToken::current();
        pieces.into_par_iter().for_each_init(state, |state, piece| {
            token.run(|| each(state, piece));
        });
    }
}

/// Returns the pool with the given number of threads, starting the pool on first use.
fn pool(threads: usize) -> PyResult<Arc<ThreadPool>> {
    let process = std::process::id();
    let mut pools = POOLS.lock().unwrap_or_else(PoisonError::into_inner);
    if pools.as_ref().is_none_or(|pools| pools.process != process) {
        // Dropping the parent's pools would wait for threads that do not exist in this process.
        std::mem::forget(pools.take());
        *pools = Some(Pools { process, by_threads: HashMap::new() });
    }
    let Some(pools) = pools.as_mut() else { unreachable!("the pools have been created") };
    if let Some(pool) = pools.by_threads.get(&threads) {
        return Ok(pool.clone());
    }
    let built = ThreadPoolBuilder::new()
        .num_threads(threads)
        .thread_name(|i| format!("intertri-{i}"))
        .build();
    let pool = built.map_err(|error| {
        PyRuntimeError::new_err(format!("cannot start {threads} threads: {error}"))
    })?;
    let pool = Arc::new(pool);
    pools.by_threads.insert(threads, pool.clone());
    Ok(pool)
}
