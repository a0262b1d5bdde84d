//! Checks that standard output is open, and opens it for writing without a buffer.

use std::io::{self, Write};

use crate::error::{Error, Result};

/// The name of standard output in error messages.
pub(crate) const NAME: &str = "standard output";

/// Refuses a closed standard output, because everything written to it would be lost silently.
pub(crate) fn check() -> Result<()> {
    if at_the_start::was_closed() {
        return Err(Error::at(NAME, "is closed; open it, or redirect it to /dev/null"));
    }
    Ok(())
}

/// Opens standard output unbuffered. `io::stdout` is line-buffered: it would search raw answers for
/// line ends, and write the bytes after the last line end separately.
pub(crate) fn open() -> Result<Box<dyn Write + Send>> {
    unbuffered().map_err(|cause| Error::at(NAME, format!("cannot write the answers: {cause}")))
}

#[cfg(unix)]
fn unbuffered() -> io::Result<Box<dyn Write + Send>> {
    use std::fs::File;
    use std::os::fd::AsFd;
    Ok(Box::new(File::from(io::stdout().as_fd().try_clone_to_owned()?)))
}

#[cfg(not(unix))]
fn unbuffered() -> io::Result<Box<dyn Write + Send>> {
    Ok(Box::new(io::stdout()))
}

/// Records whether standard output was closed at the start. The standard library reopens a closed
/// standard output as a null device before `main`, so this check runs even earlier.
#[cfg(unix)]
mod at_the_start {
    use std::sync::atomic::{AtomicBool, Ordering::Relaxed};

    static WAS_CLOSED: AtomicBool = AtomicBool::new(false);

    // `ctor` marks functions that run before `main`, when much of the standard library is not ready
    // yet. This function makes only a system call.
    ctor::declarative::ctor! {
        #[ctor(unsafe)]
        fn look() {
            WAS_CLOSED.store(rustix::io::fcntl_getfd(rustix::stdio::stdout()).is_err(), Relaxed);
        }
    }

    pub(super) fn was_closed() -> bool {
        WAS_CLOSED.load(Relaxed)
    }
}

#[cfg(not(unix))]
mod at_the_start {
    pub(super) fn was_closed() -> bool {
        false
    }
}
