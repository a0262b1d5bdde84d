//! Helpers that do not depend on rays: lane operations, threads, fallible allocation, prefetching,
//! and cancellation.

pub(crate) mod crowd;
pub(crate) mod lane_ops;
pub(crate) mod memory;
pub(crate) mod patience;
pub(crate) mod prefetch;
pub(crate) mod stop;
#[cfg(test)]
pub(crate) mod test_numbers;
pub(crate) mod threads;
