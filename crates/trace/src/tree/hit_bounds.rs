//! The box in which a triangle can be hit. The reference may also hit the thinnest triangles outside it. A
//! triangle without area is never hit, but is in the tree for closest points.
//!
//! The reference computes the normal in f64, with an error relative to the product of two edges. The thinner the
//! triangle, the further that normal can lean, and the further outside the triangle it accepts points.
//! `docs/numerics/hierarchy.md` bounds how far.

use intertri::Triangle;
use intertri::internal::exact::has_area;

use super::aabb::Aabb;

/// The box in which a triangle can be hit.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum HitBounds {
    /// Nowhere: the triangle is not finite.
    Nowhere,
    /// Nowhere: the triangle has no area. For closest points it is a segment or a point in this box.
    Degenerate(Aabb),
    /// In its box; for the reference, up to `lean` outside it.
    Box { bounds: Aabb, lean: f32 },
    /// In its box; for the reference anywhere, because the error of the normal has no useful bound.
    Thin(Aabb),
}

/// Up to this thinness (2^25) the margin is small enough to widen all boxes of the tree.
const THIN: f64 = (1_u64 << 25) as f64;

/// Beyond this thinness (2^44) there is no bound on where the reference accepts a point.
const NEEDLE: f64 = (1_u64 << 44) as f64;

/// How far outside a triangle of thinness 1 with longest edge 1 a point is accepted: 64 · 2^-53.
const LEAN: f64 = 1.0 / (1_u64 << 47) as f64;

/// Finds the [`HitBounds`] of a triangle.
pub(crate) fn hit_bounds(triangle: &Triangle) -> HitBounds {
    let Some(bounds) = Aabb::of(triangle) else { return HitBounds::Nowhere };

    // The square of the longest edge over the length of the normal.
    let [c1, c2, c3] = triangle.0.map(|c| c.map(f64::from));
    let sub = |a: [f64; 3], b: [f64; 3]| [a[0] - b[0], a[1] - b[1], a[2] - b[2]];
    let dot = |a: [f64; 3], b: [f64; 3]| a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
    let (h4, h5, h6) = (sub(c2, c1), sub(c3, c1), sub(c3, c2));
    let n = [
        h4[1] * h5[2] - h4[2] * h5[1],
        h4[2] * h5[0] - h4[0] * h5[2],
        h4[0] * h5[1] - h4[1] * h5[0],
    ];
    let square = dot(h4, h4).max(dot(h5, h5)).max(dot(h6, h6));
    // h²/|n|, at least 1.15: the computed normal leans by a share of this (hierarchy.md, section 1).
    let thinness = square / dot(n, n).sqrt();

    if n == [0.0; 3] {
        // The reference never hits it. `exact` hits it in its box if its area was rounded to 0 in f64.
        let lean = 0.0;
        if has_area(triangle) {
            HitBounds::Box { bounds, lean }
        } else {
            HitBounds::Degenerate(bounds)
        }
    } else {
        let lean = ((LEAN * thinness * square.sqrt()) as f32).next_up();
        let padded = bounds.padded(lean);
        // `Margin` adds a small lean to every box at query time. A large one would make all boxes wide, so
        // only this triangle's is padded.
        if thinness <= THIN {
            HitBounds::Box { bounds, lean }
        } else if thinness <= NEEDLE && padded.is_finite() {
            HitBounds::Box { bounds: padded, lean: 0.0 }
        } else {
            HitBounds::Thin(bounds)
        }
    }
}
