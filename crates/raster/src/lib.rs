//! Clip, z-buffer and stencil shadow volumes: the second eye that must see what the rays see.

mod adjacency;
mod batch;
mod clip;
mod differences;
mod plane;
mod shadow_differences;
mod silhouette;
mod spans;
mod stencil;
mod threads;
mod vector;
mod view;
mod volume;
mod z_buffer;

pub use adjacency::{Adjacency, Edge, Side};
pub use clip::{ALL_WALLS, NO_FAR_WALL, Point4, Scratch, clip_edge, clip_facet, outcode};
pub use differences::{Verdict, differences};
pub use shadow_differences::shadow_differences;
pub use silhouette::{Light, Outline, facing, silhouette};
pub use stencil::lit;
pub use view::{MAX_SIDE, SUBPIXEL_BITS, View, ViewError};
pub use volume::{LightError, Volume};
pub use z_buffer::{facets, triangles};
