//! The pipes at both ends of the program.

/// The capacity of a pipe: the most that Linux allows unprivileged users by default.
#[cfg(target_os = "linux")]
const CAPACITY: usize = 1 << 20;

/// Enlarges the pipes at standard input and output, if there are any, so that they hold a batch. By default
/// they hold 64 KB, and a writer would wait for its reader after every few rays.
#[cfg(target_os = "linux")]
pub(crate) fn widen_pipes() {
    use std::io::{stdin, stdout};
    // This fails for anything but a pipe, and a pipe keeps its size if memory runs out.
    let _ = rustix::pipe::fcntl_setpipe_size(stdin(), CAPACITY);
    let _ = rustix::pipe::fcntl_setpipe_size(stdout(), CAPACITY);
}

#[cfg(not(target_os = "linux"))]
pub(crate) fn widen_pipes() {}
