//! How rays and triangles lie in the lanes.

/// The elements that fill the lanes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Form {
    /// N rays against one triangle after another.
    Packets,
    /// One ray after another against N triangles.
    Blocks,
}

impl Form {
    /// `packets` or `packs`, as the published tables have it; packs are triangle blocks.
    pub fn name(self) -> &'static str {
        match self {
            Self::Packets => "packets",
            Self::Blocks => "packs",
        }
    }

    /// The form in words, for a heading.
    pub fn label(self) -> &'static str {
        match self {
            Self::Packets => "packets",
            Self::Blocks => "triangle blocks",
        }
    }
}

/// Which form, and how many lanes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Layout {
    /// The elements in the lanes.
    pub form: Form,
    /// 1, 4, 8 or 16.
    pub lanes: usize,
}
