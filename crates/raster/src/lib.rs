//! Clip, z-buffer and stencil shadow volumes: the second eye that must see what the rays see.

mod batch;
mod clip;
mod plane;
mod spans;
mod threads;
mod vector;
mod view;
mod z_buffer;

pub use clip::{ALL_WALLS, NO_FAR_WALL, Point4, Scratch, clip_edge, clip_facet, outcode};
pub use view::{MAX_SIDE, SUBPIXEL_BITS, View, ViewError};
pub use z_buffer::{facets, triangles};
