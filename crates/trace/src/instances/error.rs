//! Errors from editing or committing a scene.

use std::fmt;

use super::hit::InstanceId;
use crate::util::memory::NoMemory;

/// The reason that a scene could not be changed or committed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum SceneError {
    /// A matrix entry is NaN or infinite.
    NotFinite {
        /// The row number, counted from 0.
        row: usize,
        /// The column number, counted from 0.
        column: usize,
    },
    /// The instance does not exist or was removed.
    NoInstance(InstanceId),
    /// The scene already has the maximum number of instances.
    TooManyInstances,
    /// Memory ran out.
    OutOfMemory,
}

impl fmt::Display for SceneError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::NotFinite { row, column } => {
                write!(
                    f,
                    "row {row}, column {column} of the matrix is not finite: use finite numbers"
                )
            }
            Self::NoInstance(id) => {
                let id = id.index();
                write!(
                    f,
                    "the scene has no instance {id}: it was removed, or belongs to another scene"
                )
            }
            Self::TooManyInstances => f.write_str(
                "the scene already holds the maximum of 2^31 instances: remove some first",
            ),
            Self::OutOfMemory => f.write_str("too little memory for the scene: remove instances"),
        }
    }
}

impl std::error::Error for SceneError {}

impl From<NoMemory> for SceneError {
    fn from(NoMemory: NoMemory) -> Self {
        Self::OutOfMemory
    }
}
