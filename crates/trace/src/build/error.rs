//! The error for a hierarchy that cannot be built.

use std::fmt;

/// The reason that a hierarchy cannot be built.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum BuildError {
    /// There are too many triangles for 31-bit indices.
    TooManyTriangles {
        /// The number of triangles.
        count: usize,
    },
    /// There is not enough memory.
    OutOfMemory {
        /// The number of triangles.
        count: usize,
    },
    /// An index is out of bounds.
    BadIndex {
        /// The index of the mesh, which is 0 if there is only one.
        geometry: usize,
        /// The index of the triangle within the mesh.
        triangle: usize,
        /// The vertex index that is out of bounds.
        index: u32,
        /// The number of vertices in the mesh.
        vertices: usize,
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
                "a hierarchy of {count} triangles needs more memory than is available: split them into parts"
            ),
            Self::BadIndex { geometry, triangle, index, vertices } => {
                if *geometry > 0 {
                    write!(f, "mesh {geometry}: ")?;
                }
                write!(
                    f,
                    "triangle {triangle} has vertex {index}, but there are {vertices} vertices"
                )
            }
        }
    }
}

impl std::error::Error for BuildError {}
