//! Why there is no hierarchy.

use std::fmt;

/// Why there is no hierarchy.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum BuildError {
    /// Triangles are numbered with 31 bits.
    TooManyTriangles {
        /// How many there were.
        count: usize,
    },
    /// There is too little memory.
    OutOfMemory {
        /// How many triangles there were.
        count: usize,
    },
}

impl fmt::Display for BuildError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::TooManyTriangles { count } => write!(
                f,
                "{count} triangles are too many for one hierarchy: split them into parts of at most 2147483647"
            ),
            Self::OutOfMemory { count } => write!(
                f,
                "a hierarchy of {count} triangles needs more memory than there is: split them into parts"
            ),
        }
    }
}

impl std::error::Error for BuildError {}
