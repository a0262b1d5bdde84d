//! The segments of a ray, and the crossings between them.

use intertri::Hit;

/// A part of a ray in one medium: [`Media::segments`](crate::Media::segments).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Segment {
    /// The t where it starts.
    pub start: f64,
    /// The t where it ends, and the next one starts.
    pub end: f64,
    /// The medium; `None` outside.
    pub medium: Option<u32>,
    /// The wall at its end; [`Hit::MISS`] at the end of the ray.
    pub wall: Hit,
}

/// A crossing from one medium into another: [`Media::next_crossing`](crate::Media::next_crossing).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MediumCrossing {
    /// The wall between them. Its geometry is the index of the mesh.
    pub hit: Hit,
    /// The medium before the wall; `None` outside.
    pub left: Option<u32>,
    /// The medium after the wall; `None` outside.
    pub entered: Option<u32>,
}
