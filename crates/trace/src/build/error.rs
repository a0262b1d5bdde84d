//! Why there is no hierarchy.

use std::fmt;

/// Why there is no hierarchy.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum BuildError {
    /// Triangles are numbered with 31 bits.
    TooManyTriangles {
        /// How many there were.
        count: usize,
    },
}

impl fmt::Display for BuildError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self::TooManyTriangles { count } = self;
        write!(
            f,
            "{count} triangles are too many for one hierarchy: split them into parts of at most 2147483647"
        )
    }
}

impl std::error::Error for BuildError {}
