//! Document B: finds the facet that a pixel shows, from the signs of cross products and the
//! smallest depth.
//!
//! ```text
//!          a2                   v_k = a_(k+1) - a_k    along the outline, closed at its end
//!         /  \                  r_k = p - a_k          to the pixel's centre
//!    v1  / p   \  v2            c_kz = v_kx * r_ky - v_ky * r_kx
//!       /  .     \
//!     a1 --------- a3           Here, clockwise with y up, every c_kz is negative.
//!            v3
//! ```
//!
//! Facets are convex and have three or more vertices in screen coordinates: x and y in pixels, and
//! z as the depth. The pixel in column `n` and row `m` has its centre at `(n + 0.5, m + 0.5)`.
//!
//! # What is illegible in the scanned document, and what is added here
//! - **The minus signs** of the differences and of `c_kz`. They follow from the document's figure.
//! - **The other orientation.** The document's rule, every `c_kz <= 0`, holds for outlines that run
//!   clockwise if y points up (counter-clockwise on a screen with y downward). An image contains
//!   outlines of both orientations, so [`ZBuffer::draw`] mirrors the rule for the other
//!   orientation.
//! - **Facets with zero area.** If three vertices are collinear, every `c_kz` is 0 along their
//!   line; if they are equal, every `c_kz` is 0 everywhere. [`ZBuffer::draw`] skips such facets.
//! - **The depth within a facet** is taken where its plane meets the pixel's projector. For a facet
//!   of four or more vertices that is not flat, this is the plane with its mean normal through its
//!   first vertex. The more edge-on a facet is, the less accurate its depth.
//!
//! If a facet is concave, only the points inside all of its edges are drawn. Cut concave facets
//! into convex facets first, as the document does with curved facets.

use alloc::vec;
use alloc::vec::Vec;

use crate::vector::Vector;

/// Computes the document's `c_kz` for each vertex of the outline, in order. z coordinates are
/// ignored.
pub fn turns(outline: &[Vector], p: Vector) -> impl Iterator<Item = f64> {
    let next = outline.iter().cycle().skip(1);
    outline.iter().zip(next).map(move |(&a, &b)| {
        let v = b - a;
        let r = p - a;
        v.x * r.y - v.y * r.x
    })
}

/// Applies the document's test for a clockwise outline (y up): a point is inside if no `c_kz` is
/// positive, so edges and vertices belong to the facet. NaN is outside. An outline with no vertices
/// contains every point.
pub fn inside(outline: &[Vector], p: Vector) -> bool {
    turns(outline, p).all(|c| c <= 0.0)
}

/// An image that stores the nearest facet so far for each pixel.
#[derive(Clone, Debug, PartialEq)]
pub struct ZBuffer {
    /// The width in pixels.
    pub width: usize,
    /// The height in pixels.
    pub height: usize,
    /// The smallest z, row by row; infinity where there is no facet.
    pub depth: Vec<f64>,
    /// The number of the facet with the smallest z, or `None` where there is no facet.
    pub facet: Vec<Option<usize>>,
}

impl ZBuffer {
    /// Creates an empty image.
    pub fn new(width: usize, height: usize) -> Self {
        let pixels = width * height;
        Self { width, height, depth: vec![f64::INFINITY; pixels], facet: vec![None; pixels] }
    }

    /// Draws a convex facet, whose number the caller chooses.
    ///
    /// A facet owns the pixels whose centres are inside it or on its outline, where its depth is
    /// smaller than the stored depth. If depths are equal, the facet drawn first stays. Depth has
    /// no near or far limit. Facets that have fewer than three vertices, are degenerate, or have
    /// vertices that are not finite are not drawn.
    pub fn draw(&mut self, facet: usize, outline: &[Vector]) {
        let Some((&a1, others)) = outline.split_first() else { return };

        // The normal is the sum of the cross products over the fan around the first vertex. Its z
        // is twice the signed area, which is positive if the outline runs against the document's
        // direction.
        let normal = others
            .windows(2)
            .map(|pair| (pair[0] - a1) ^ (pair[1] - a1))
            .fold(Vector::default(), |sum, n| sum + n);
        if normal.z == 0.0 || !<[f64; 3]>::from(normal).iter().all(|n| n.is_finite()) {
            return;
        }

        for m in 0..self.height {
            for n in 0..self.width {
                let p = Vector::new(n as f64 + 0.5, m as f64 + 0.5, 0.0);

                // Check whether the centre is inside.
                let inside = if normal.z < 0.0 {
                    inside(outline, p)
                } else {
                    turns(outline, p).all(|c| c >= 0.0)
                };
                if !inside {
                    continue;
                }

                // Where does the projector meet the facet's plane, and is that the nearest so far?
                let r = p - a1;
                let z = a1.z - (normal.x * r.x + normal.y * r.y) / normal.z;
                let pixel = m * self.width + n;
                if z < self.depth[pixel] {
                    self.depth[pixel] = z;
                    self.facet[pixel] = Some(facet);
                }
            }
        }
    }
}
