//! Finds the precision that a frame needs by comparing, for several kinds of arithmetic, how many
//! pixels each can get wrong at most and how many it actually gets wrong.
//!
//! There are three kinds of arithmetic: f64 as in the reference (whose answers `certified`
//! returns), a plain f32 test, and integers on a grid. At a pixel, an arithmetic certainly finds
//! the exact answer if
//!
//! - rounding or snapping cannot move the ray across a side of any triangle in front of the visible
//!   one, and
//! - no two triangles at the pixel are closer to each other than their errors in depth.
//!
//! All other pixels are doubtful, and only doubtful pixels can be wrong. On a sample of the pixels,
//! this prediction and every engine's answers are checked against the exact answers.
//! `docs/advise.md` derives the bounds.

mod arithmetic;
mod band;
mod camera;
mod facet;
mod footprint;
mod needs;
mod outcome;
mod pixel;
mod pixel_ray;
mod scan;
mod scan_result;
mod vector;

pub use arithmetic::Arithmetic;
pub use camera::PinholeCamera;
pub use needs::{Needs, needs};
pub use scan::scan;
pub use scan_result::{SampledPixel, ScanResult};

#[cfg(test)]
mod tests;
