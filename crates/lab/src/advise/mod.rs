//! What a frame needs: how many pixels an arithmetic can get wrong at most, and how many it does.
//!
//! Three arithmetics are asked about: the reference's f64 (whose answers `certified` and `double`
//! give), a plain f32 test, and integers on a grid. For each pixel the exact answer is known to stay
//! the answer wherever
//!
//! - the ray passes every side of every triangle in front of what is seen farther away than rounding
//!   or snapping can move it, and
//! - no two triangles at the pixel are closer to each other than their errors of depth.
//!
//! All other pixels are counted as doubtful: as many can be wrong, and no more. That is a prediction;
//! on a sample of the pixels it is held against the exact answer, and so are those who answered.
//! The bounds are derived in `docs/advise.md`.

mod facet;
mod needs;
mod scan;

use intertri::{Ray, Vec3};

pub use needs::{Needs, needs};
pub use scan::{Exact, Scan, scan};

/// A vector of one lane.
type V = Vec3<f64>;

/// A camera and its picture.
#[derive(Clone, Copy)]
pub struct View<'a> {
    /// Where all rays start.
    pub eye: [f32; 3],
    /// To the right, up, and into the picture; of unit length, at right angles.
    pub axes: [[f64; 3]; 3],
    /// Half of the picture's height at distance 1.
    pub half_height: f64,
    /// Pixels in a row, and rows.
    pub size: (u32, u32),
    /// The ray of a pixel: column and row from the top left.
    pub ray: &'a (dyn Fn(u32, u32) -> Ray + Sync),
}

impl View<'_> {
    /// The angle of a pixel in the middle of the picture.
    fn pixel(&self) -> f64 {
        2.0 * self.half_height / f64::from(self.size.1)
    }
}

/// What computes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Arithmetic {
    /// The reference's f64, with a threshold.
    Double {
        /// Document A's `Threshold`.
        threshold: f64,
    },
    /// Möller and Trumbore's test in f32, products not fused, without an epsilon.
    Single,
    /// Integers.
    Grid {
        /// The distance of neighbouring points of the grid.
        step: f64,
        /// The bits of a direction.
        q: u32,
    },
}

#[cfg(test)]
mod tests;
