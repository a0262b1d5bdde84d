//! The segments of a ray, and the crossings at which its medium changes.

use intertri::Hit;

/// A part of a ray within one medium; see [`Media::segments`](crate::Media::segments).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Segment {
    /// The t at which the segment starts.
    pub start: f64,
    /// The t at which the segment ends and the next one starts.
    pub end: f64,
    /// The medium, or `None` outside all meshes.
    pub medium: Option<u32>,
    /// The wall at the end of the segment, or [`Hit::MISS`] at the end of the ray.
    pub wall: Hit,
}

/// A crossing from one medium into another; see
/// [`Media::next_crossing`](crate::Media::next_crossing).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MediumCrossing {
    /// The hit on the wall between the media. Its geometry is the index of the mesh.
    pub hit: Hit,
    /// The medium before the wall, or `None` outside all meshes.
    pub left: Option<u32>,
    /// The medium after the wall, or `None` outside all meshes.
    pub entered: Option<u32>,
}
