//! Why a saved scene could not be loaded.

use std::{fmt, io};

use super::error::LoadError;
use crate::util::memory::NoMemory;

/// Why a saved scene could not be loaded, in one line.
#[derive(Debug)]
#[non_exhaustive]
pub enum SceneLoadError {
    /// It does not begin like a saved scene.
    NotSaved,
    /// It was written by a later version of this crate.
    Newer {
        /// The part that is unknown to this version.
        what: String,
    },
    /// It ends before it should.
    CutOff,
    /// Its contents have changed since it was written.
    Damaged {
        /// What is damaged.
        what: &'static str,
    },
    /// One of its meshes cannot be loaded.
    Mesh {
        /// The mesh, counted from 0 in the order of the file.
        index: usize,
        /// Why.
        error: LoadError,
    },
    /// There is too little memory.
    OutOfMemory,
    /// It cannot be read.
    Io(io::Error),
}

impl SceneLoadError {
    pub(super) fn damaged<T>(what: &'static str) -> Result<T, Self> {
        Err(Self::Damaged { what })
    }

    /// The error of a mesh.
    pub(crate) fn of_mesh(index: usize, error: LoadError) -> Self {
        match error {
            // These say nothing about the mesh.
            LoadError::CutOff => Self::CutOff,
            LoadError::OutOfMemory => Self::OutOfMemory,
            LoadError::Io(error) => Self::Io(error),
            error => Self::Mesh { index, error },
        }
    }
}

/// The error of a section.
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
