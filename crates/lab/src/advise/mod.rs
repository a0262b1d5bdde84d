//! The precision that a frame needs: how many pixels an arithmetic can get wrong at most, and how many it does.
//!
//! Three arithmetics are asked about: the reference's f64 (whose answers `certified` and `double`
//! give), a plain f32 test, and integers on a grid. For each pixel the exact answer is known to stay
//! the answer wherever
//!
//! - the ray passes every side of every triangle in front of what is seen farther away than rounding
//!   or snapping can move it, and
//! - no two triangles at the pixel are closer to each other than their errors of depth.
//!
//! All other pixels count as doubtful: as many can be wrong, and no more. That is a prediction;
//! on a sample of the pixels it is checked against the exact answer, and so is every engine.
//! The bounds are derived in `docs/advise.md`.

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
