//! The program's errors: each has a one-line message for people and an exit code for scripts.

use std::fmt;
use std::io::{self, Write};
use std::panic::{self, PanicHookInfo};
use std::path::Path;
use std::process::{self, ExitCode};

use clap::error::ErrorKind;
use intertri_scene::PartialFile;

/// The reason why the program failed. One line says what failed, where, and what to do.
#[derive(Debug)]
pub(crate) struct Error {
    what: String,
    /// The exit code.
    code: u8,
}

pub(crate) type Result<T> = std::result::Result<T, Error>;

impl Error {
    /// Creates an error with this message and exit code 1.
    pub(crate) fn new(what: impl Into<String>) -> Self {
        Self { what: what.into(), code: 1 }
    }

    /// Creates a command-line error, with exit code 2.
    pub(crate) fn usage(what: impl Into<String>) -> Self {
        Self { what: what.into(), code: 2 }
    }

    /// Creates an error about a file or stream.
    pub(crate) fn at(place: impl fmt::Display, cause: impl fmt::Display) -> Self {
        Self::new(format!("{place}: {cause}"))
    }

    /// Returns the same error, preceded by the name of the file.
    pub(crate) fn of(self, file: &Path) -> Self {
        Self { what: format!("{}: {}", file.display(), self.what), ..self }
    }

    /// Creates an error about something that needs too much memory.
    pub(crate) fn no_memory(what: impl fmt::Display) -> Self {
        Self::new(format!("{what} need more memory than is available"))
    }

    /// Creates an error about a thread that did not start.
    pub(crate) fn no_thread(cause: impl fmt::Display) -> Self {
        Self::new(format!(
            "cannot start a thread: {cause}; free some memory, or set RAYON_NUM_THREADS=1"
        ))
    }

    /// Prints the error and returns its exit code.
    pub(crate) fn tell(&self) -> ExitCode {
        note(&self.what);
        ExitCode::from(self.code)
    }
}

// Errors from the other crates already say what failed, where, and what to do.
macro_rules! from {
    ($($error:ty),*) => {$(
        impl From<$error> for Error {
            fn from(error: $error) -> Self {
                Self::new(error.to_string())
            }
        }
    )*};
}

from!(
    intertri::fixed::GridError,
    intertri_scene::LoadError,
    intertri_scene::CameraError,
    intertri_scene::ImageError,
    intertri_raster::LightError,
    intertri_raster::ViewError,
    intertri_trace::BuildError,
    intertri_trace::OutOfMemory,
    intertri_trace::SceneError
);

/// Makes every panic print one line, without a backtrace.
///
/// The standard library's own message can hang: if `RUST_BACKTRACE` is set, it holds a lock while
/// it prints a backtrace, and if memory runs out during that, reporting it waits for the same lock.
pub(crate) fn report_panics_in_one_line() {
    panic::set_hook(Box::new(|panic| {
        let message = panic_message(panic);
        // A new thread panics before it runs anything if no memory is left for its signal stack.
        // That panic cannot be caught, so the run ends here.
        if message.contains("alternative stack") {
            PartialFile::abandon_all();
            Error::no_thread(message).tell();
            process::exit(1);
        }
        let place = panic.location().map_or_else(String::new, |at| format!(" at {at}"));
        note(&format!("internal error{place}: {message}; please report it"));
    }));
}

fn panic_message<'a>(panic: &'a PanicHookInfo<'_>) -> &'a str {
    let message = panic.payload().downcast_ref::<&str>().copied();
    message.or_else(|| panic.payload().downcast_ref::<String>().map(String::as_str)).unwrap_or("?")
}

/// Prints a command-line error, or the requested help.
pub(crate) fn command_line(error: &clap::Error) -> ExitCode {
    match error.kind() {
        ErrorKind::DisplayHelp | ErrorKind::DisplayVersion => {
            // If the reader closed standard output, the help is no longer wanted.
            let _ = error.print();
            ExitCode::SUCCESS
        }
        ErrorKind::DisplayHelpOnMissingArgumentOrSubcommand => {
            let _ = error.print();
            ExitCode::from(2)
        }
        _ => {
            // Print only the first paragraph, which names the error, because usage and hints would
            // fill a screen.
            let text = error.to_string();
            let cause = text.lines().map(str::trim).take_while(|line| !line.is_empty());
            let cause = cause.collect::<Vec<_>>().join(" ");
            let cause = cause.strip_prefix("error: ").unwrap_or(&cause);
            Error::usage(format!("{cause}; see intertri --help")).tell()
        }
    }
}

/// Prints one line on standard error. Control characters, which may occur in file names, are
/// escaped.
pub(crate) fn note(what: &str) {
    let mut line = String::from("intertri: ");
    for c in what.chars() {
        if c.is_control() {
            line.extend(c.escape_default());
        } else {
            line.push(c);
        }
    }
    line.push('\n');
    // If standard error is closed, only the exit code can report the error.
    let _ = io::stderr().write_all(line.as_bytes());
}
