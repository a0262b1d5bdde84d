//! The arrangement of rays and triangles in SIMD lanes.

/// Whether rays or triangles fill the lanes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Form {
    /// Rays fill the lanes: N rays are tested against one triangle after another.
    Packets,
    /// Triangles fill the lanes: one ray after another is tested against N triangles.
    Blocks,
}

impl Form {
    /// Returns the name in the published tables: `packets`, or `packs` for blocks of triangles.
    pub fn name(self) -> &'static str {
        match self {
            Self::Packets => "packets",
            Self::Blocks => "packs",
        }
    }

    /// Returns the form in words, for a heading.
    pub fn label(self) -> &'static str {
        match self {
            Self::Packets => "packets",
            Self::Blocks => "triangle blocks",
        }
    }
}

/// The form of a layout and its number of lanes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Layout {
    /// Whether rays or triangles fill the lanes.
    pub form: Form,
    /// The number of lanes: 1, 4, 8, or 16.
    pub lanes: usize,
}
