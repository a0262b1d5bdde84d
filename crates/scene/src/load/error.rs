//! Errors in model files, reported with the file, the line, and the cause.

use std::collections::TryReserveError;
use std::path::{Path, PathBuf};
use std::{fmt, io};

/// The reason that a model could not be read. The error is displayed as one line:
/// `file:line: cause`.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct LoadError {
    /// The file.
    pub path: PathBuf,
    /// In a text file, the line with the error, counted from 1.
    pub line: Option<u64>,
    /// The problem, and how to solve it unless that is obvious.
    pub cause: String,
}

impl fmt::Display for LoadError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}:", self.path.display())?;
        if let Some(line) = self.line {
            write!(f, "{line}:")?;
        }
        write!(f, " {}", self.cause)
    }
}

impl std::error::Error for LoadError {}

/// A [`LoadError`] that does not contain the file's name yet.
pub(super) struct Fault {
    pub(super) line: Option<u64>,
    pub(super) cause: String,
}

impl Fault {
    /// Returns the same fault with a line number.
    pub(super) fn at(self, line: u64) -> Self {
        Self { line: Some(line), ..self }
    }

    /// Converts the fault to the error for a file.
    pub(super) fn of(self, path: &Path) -> LoadError {
        LoadError { path: path.into(), line: self.line, cause: self.cause }
    }
}

impl From<io::Error> for Fault {
    fn from(error: io::Error) -> Self {
        Self { line: None, cause: format!("cannot read it: {error}") }
    }
}

impl From<TryReserveError> for Fault {
    fn from(_: TryReserveError) -> Self {
        let cause = "it needs more memory than is available; cut the model into parts";
        Self { line: None, cause: cause.to_owned() }
    }
}

/// Returns an error without a line number.
pub(super) fn fault<T>(cause: impl Into<String>) -> Result<T, Fault> {
    Err(Fault { line: None, cause: cause.into() })
}

/// Quotes a word from a file for an error message. Control characters are escaped, and long words
/// are shortened.
pub(super) fn quote(word: &str) -> String {
    let short: String = word.chars().take(32).collect();
    format!("{short:?}{}", if short.len() < word.len() { "..." } else { "" })
}
