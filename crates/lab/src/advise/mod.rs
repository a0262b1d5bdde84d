//! The precision that a frame needs: the most pixels that an arithmetic can get wrong, and the number that it
//! does.
//!
//! Compares three arithmetics: the reference's f64 (whose answers `certified` returns), a plain f32 test, and
//! integers on a grid. For each pixel the exact answer is known to be the answer if
//!
//! - rounding or snapping cannot move the ray across a side of any triangle in front of the visible one, and
//! - no two triangles at the pixel are closer to each other than their errors in depth.
//!
//! All other pixels are doubtful: only they can be wrong. That is a prediction; it is checked against the
//! exact answer on a sample of the pixels, as is every engine. `docs/advise.md` derives the bounds.

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
