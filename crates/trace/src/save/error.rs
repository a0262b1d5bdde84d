//! Errors from loading a saved hierarchy.

use std::{fmt, io};

use crate::util::memory::NoMemory;

/// The reason that a saved hierarchy could not be loaded. The message fits on one line.
#[derive(Debug)]
#[non_exhaustive]
pub enum LoadError {
    /// The input does not start with the magic number of a saved hierarchy.
    NotSaved,
    /// The input was written by a later version of this crate.
    Newer {
        /// The feature that this version does not support.
        what: String,
    },
    /// The input was written by an earlier version of this crate, which omitted triangles that
    /// closest-point queries consider.
    Older,
    /// The coordinates have the other scalar type: the hierarchy is a `Bvh<f64>` where a `Bvh<f32>`
    /// was expected, or vice versa.
    Scalar {
        /// The scalar type found: `f32` or `f64`.
        found: &'static str,
    },
    /// The input is truncated.
    CutOff,
    /// The contents have changed since they were written.
    Damaged {
        /// A description of the damage.
        what: &'static str,
    },
    /// Memory ran out.
    OutOfMemory,
    /// The input could not be read.
    Io(io::Error),
}

impl LoadError {
    pub(super) fn damaged<T>(what: &'static str) -> Result<T, Self> {
        Err(Self::Damaged { what })
    }
}

impl From<NoMemory> for LoadError {
    fn from(_: NoMemory) -> Self {
        Self::OutOfMemory
    }
}

impl From<io::Error> for LoadError {
    fn from(error: io::Error) -> Self {
        match error.kind() {
            io::ErrorKind::UnexpectedEof => Self::CutOff,
            io::ErrorKind::OutOfMemory => Self::OutOfMemory,
            _ => Self::Io(error),
        }
    }
}

impl fmt::Display for LoadError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::NotSaved => f.write_str("is not a saved hierarchy (bad magic number)"),
            Self::Newer { what } => {
                write!(f, "written by a newer version ({what}); save it again with this one")
            }
            Self::Older => f.write_str(
                "the saved hierarchy has version 1, which omits triangles with zero area; \
                 build it again",
            ),
            Self::Scalar { found } => {
                write!(f, "the coordinates of the saved hierarchy are {found}: load it as such")
            }
            Self::CutOff => f.write_str("the saved hierarchy is cut off"),
            Self::Damaged { what } => write!(f, "the saved hierarchy is damaged: {what}"),
            Self::OutOfMemory => {
                f.write_str("the saved hierarchy needs more memory than is available")
            }
            Self::Io(error) => write!(f, "cannot read it: {error}"),
        }
    }
}

impl std::error::Error for LoadError {
    fn source(&self) -> Option<&(dyn std::error::Error + 'static)> {
        match self {
            Self::Io(error) => Some(error),
            _ => None,
        }
    }
}
