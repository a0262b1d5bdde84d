//! Clipping, z-buffer, and stencil shadow volumes: an independent renderer for verifying the ray
//! tracer.
//!
//! [`facets`] and [`triangles`] fill a visibility buffer, one [`intertri::Hit`] per pixel, as a
//! tracer does with one ray per pixel. [`lit`] fills a shadow mask for any visibility buffer, as a
//! tracer does with one shadow ray per pixel. [`differences`] and [`shadow_differences`] decide
//! pixel by pixel whether two engines may disagree. [`wire`] draws the visible edges over an image.
//!
//! ```
//! use intertri::Triangle;
//! use intertri_raster::{Adjacency, Light, View, Volume, lit, triangles};
//!
//! // A floor, and a sheet halfway between the floor and the light.
//! let square = |y: f32, half: f32| {
//!     let p = |x: f32, z: f32| [x * half, y, z * half - 4.0];
//!     let (a, b, c, d) = (p(-1.0, -1.0), p(-1.0, 1.0), p(1.0, 1.0), p(1.0, -1.0));
//!     [Triangle([a, b, c]), Triangle([a, c, d])]
//! };
//! let soup = [square(-1.0, 2.0), square(0.5, 0.4)].concat();
//!
//! let axes = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, -1.0]];
//! let view = View::new([0.0; 3], axes, 0.5, 64, 48)?;
//! let hits = triangles(&view, &soup, 1e-9);
//!
//! let adjacency = Adjacency::new(&soup);
//! let light = Light::Point { position: [0.0, 2.0, -4.0], reach: 1.0 };
//! let mask = lit(&view, &hits, &Volume::new(&adjacency, light)?);
//! // The light is directly above the sheet, so the shadow is directly below it.
//! let shadow = 36 * 64 + 32;
//! assert!(hits[shadow].triangle < 2 && !mask[shadow]);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod adjacency;
mod ball;
mod batch;
mod clip;
mod differences;
mod disc;
mod exact;
mod plane;
mod shadow_differences;
mod silhouette;
mod spans;
mod stencil;
mod threads;
mod vector;
mod view;
mod volume;
mod wire;
mod z_buffer;

pub use adjacency::{Adjacency, Edge, Side};
pub use clip::{ALL_WALLS, NO_FAR_WALL, Point4, Scratch, clip_edge, clip_facet, outcode};
pub use differences::{Verdict, differences};
pub use shadow_differences::shadow_differences;
pub use silhouette::{Light, Outline, facing, silhouette};
pub use stencil::lit;
pub use view::{MAX_SIDE, SUBPIXEL_BITS, View, ViewError};
pub use volume::{LightError, Volume};
pub use wire::wire;
pub use z_buffer::{facets, triangles};
