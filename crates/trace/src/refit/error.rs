//! Errors from refitting a hierarchy.

use std::fmt;

/// The reason that a hierarchy could not be refitted.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum RefitError {
    /// The number of triangles passed differs from the number in the hierarchy.
    Count {
        /// The number of triangles in the hierarchy.
        expected: usize,
        /// The number of triangles passed.
        found: usize,
    },
    /// Memory ran out.
    OutOfMemory,
    /// A vertex index is out of bounds.
    BadIndex {
        /// The index of the triangle that has the invalid vertex index.
        triangle: usize,
        /// The invalid vertex index.
        index: u32,
        /// The number of vertices.
        vertices: usize,
    },
}

impl fmt::Display for RefitError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Count { expected, found } => write!(
                f,
                "a hierarchy of {expected} triangles cannot be refitted to {found}; build another"
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
