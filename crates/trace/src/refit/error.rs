//! Why triangles could not be moved.

use std::fmt;

/// Why triangles could not be moved.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum RefitError {
    /// There are more triangles than it was built over, or fewer.
    Count {
        /// How many it was built over.
        expected: usize,
        /// How many there were.
        found: usize,
    },
    /// There is too little memory.
    OutOfMemory,
    /// An index is out of bounds.
    BadIndex {
        /// The triangle.
        triangle: usize,
        /// The index of its vertex.
        index: u32,
        /// How many vertices there are.
        vertices: usize,
    },
}

impl fmt::Display for RefitError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Count { expected, found } => write!(
                f,
                "a hierarchy of {expected} triangles is refitted to as many, not to {found}; build another"
            ),
            Self::BadIndex { triangle, index, vertices } => {
                write!(
                    f,
                    "triangle {triangle} has vertex {index}, but there are {vertices} vertices"
                )
            }
            Self::OutOfMemory => f.write_str("refitting needs more memory than is available"),
        }
    }
}

impl std::error::Error for RefitError {}
