//! Enlarges the pipes at standard input and output.

/// The capacity to request: the maximum that Linux allows unprivileged users by default.
#[cfg(target_os = "linux")]
const CAPACITY: usize = 1 << 20;

/// If standard input or output is a pipe, enlarges it so that it holds a batch. By default, a pipe
/// holds only 64 KB, so its writer would often have to wait for its reader.
#[cfg(target_os = "linux")]
pub(crate) fn widen_pipes() {
    use std::io::{stdin, stdout};
    // This call fails for anything other than a pipe. If memory runs out, a pipe keeps its size.
    let _ = rustix::pipe::fcntl_setpipe_size(stdin(), CAPACITY);
    let _ = rustix::pipe::fcntl_setpipe_size(stdout(), CAPACITY);
}

#[cfg(not(target_os = "linux"))]
pub(crate) fn widen_pipes() {}
