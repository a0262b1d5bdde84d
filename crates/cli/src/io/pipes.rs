//! The pipes at both ends of the program.

/// Bytes that a pipe is to hold: the most that a Linux with its usual settings allows anyone.
#[cfg(target_os = "linux")]
const CAPACITY: usize = 1 << 20;

/// Lets the pipes at standard input and output, where there are some, hold as much as a batch. They hold
/// 64 KB at first, and a writer would wait for its reader after every few rays.
#[cfg(target_os = "linux")]
pub(crate) fn widen_pipes() {
    use std::io::{stdin, stdout};
    // Anything but a pipe refuses, and a pipe keeps its size if memory runs out.
    let _ = rustix::pipe::fcntl_setpipe_size(stdin(), CAPACITY);
    let _ = rustix::pipe::fcntl_setpipe_size(stdout(), CAPACITY);
}

#[cfg(not(target_os = "linux"))]
pub(crate) fn widen_pipes() {}
