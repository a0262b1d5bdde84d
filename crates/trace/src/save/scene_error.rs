//! Errors from loading a saved scene.

use std::{fmt, io};

use super::error::LoadError;
use crate::util::memory::NoMemory;

/// The reason that a saved scene could not be loaded. The message fits on one line.
#[derive(Debug)]
#[non_exhaustive]
pub enum SceneLoadError {
    /// The input does not start with the magic number of a saved scene.
    NotSaved,
    /// The input was written by a later version of this crate.
    Newer {
        /// The feature that this version does not support.
        what: String,
    },
    /// The input is truncated.
    CutOff,
    /// The contents have changed since they were written.
    Damaged {
        /// A description of the damage.
        what: &'static str,
    },
    /// A mesh of the scene could not be loaded.
    Mesh {
        /// The position of the mesh in the file, counted from 0.
        index: usize,
        /// The error from loading the mesh.
        error: LoadError,
    },
    /// Memory ran out.
    OutOfMemory,
    /// The input could not be read.
    Io(io::Error),
}

impl SceneLoadError {
    pub(super) fn damaged<T>(what: &'static str) -> Result<T, Self> {
        Err(Self::Damaged { what })
    }

    /// Converts an error from loading a mesh.
    pub(crate) fn of_mesh(index: usize, error: LoadError) -> Self {
        match error {
            // These errors are not specific to the mesh.
            LoadError::CutOff => Self::CutOff,
            LoadError::OutOfMemory => Self::OutOfMemory,
            LoadError::Io(error) => Self::Io(error),
            error => Self::Mesh { index, error },
        }
    }
}

/// Converts an error from reading a section.
impl From<LoadError> for SceneLoadError {
    fn from(error: LoadError) -> Self {
        match error {
            LoadError::Newer { what } => Self::Newer { what },
            LoadError::CutOff => Self::CutOff,
            LoadError::Damaged { what } => Self::Damaged { what },
            LoadError::OutOfMemory => Self::OutOfMemory,
            LoadError::Io(error) => Self::Io(error),
            LoadError::NotSaved | LoadError::Older | LoadError::Scalar { .. } => Self::NotSaved,
        }
    }
}

impl From<io::Error> for SceneLoadError {
    fn from(error: io::Error) -> Self {
        LoadError::from(error).into()
    }
}

impl From<NoMemory> for SceneLoadError {
    fn from(NoMemory: NoMemory) -> Self {
        Self::OutOfMemory
    }
}

impl fmt::Display for SceneLoadError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::NotSaved => f.write_str("is not a saved scene (bad magic number)"),
            Self::Newer { what } => {
                write!(f, "written by a newer version ({what}); save it again with this one")
            }
            Self::CutOff => f.write_str("the saved scene is cut off"),
            Self::Damaged { what } => write!(f, "the saved scene is damaged: {what}"),
            Self::Mesh { index, error } => write!(f, "mesh {index} of the saved scene: {error}"),
            Self::OutOfMemory => f.write_str("the saved scene needs more memory than is available"),
            Self::Io(error) => write!(f, "cannot read it: {error}"),
        }
    }
}

impl std::error::Error for SceneLoadError {
    fn source(&self) -> Option<&(dyn std::error::Error + 'static)> {
        match self {
            Self::Mesh { error, .. } => Some(error),
            Self::Io(error) => Some(error),
            _ => None,
        }
    }
}
