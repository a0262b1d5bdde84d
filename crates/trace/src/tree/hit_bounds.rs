//! Computes the box that contains the exact hits of a triangle. Because of rounding, the reference
//! implementation may also report hits outside this box. A triangle with zero area is never hit,
//! but the tree contains it for closest-point queries.
//!
//! The reference implementation computes the normal in f64, with an error relative to the product
//! of two edge lengths. The thinner the triangle, the more its computed normal may lean, and the
//! farther outside the triangle the implementation may accept points. `docs/numerics/hierarchy.md`
//! bounds this distance.

use intertri::Triangle;
use intertri::internal::exact::has_area;

use super::aabb::Aabb;

/// The box that contains the exact hits of a triangle, and how far outside it the reference
/// implementation may report hits.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum HitBounds {
    /// The triangle is not finite and is never hit.
    Nowhere,
    /// The triangle has zero area and is never hit. In closest-point queries, it counts as a
    /// segment or point in this box.
    Degenerate(Aabb),
    /// All exact hits are inside the box. The reference implementation may also report hits up to
    /// `lean` outside it.
    Box { bounds: Aabb, lean: f32 },
    /// All exact hits are inside the box. The reference implementation may report hits arbitrarily
    /// far outside it, because the error in its normal has no useful bound.
    Thin(Aabb),
}

/// Up to this thinness (2^25), the margin is small enough to be added to all boxes of the tree.
const THIN: f64 = (1_u64 << 25) as f64;

/// Beyond this thinness (2^44), there is no bound on where the reference implementation accepts a
/// point.
const NEEDLE: f64 = (1_u64 << 44) as f64;

/// The distance outside a triangle with thinness 1 and longest edge 1 at which the reference
/// implementation may accept a point: 64 · 2^-53.
const LEAN: f64 = 1.0 / (1_u64 << 47) as f64;

/// Computes the [`HitBounds`] of a triangle.
pub(crate) fn hit_bounds(triangle: &Triangle) -> HitBounds {
    let Some(bounds) = Aabb::of(triangle) else { return HitBounds::Nowhere };

    // Compute the squared length of the longest edge, divided by the length of the normal.
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
    // The thinness is h²/|n|, which is at least 1.15. The computed normal leans in proportion to it
    // (hierarchy.md, section 1).
    let thinness = square / dot(n, n).sqrt();

    if n == [0.0; 3] {
        // The reference implementation never reports a hit on this triangle. If its area was merely
        // rounded to 0 in f64, the `exact` mode finds hits, which are inside its box.
        let lean = 0.0;
        if has_area(triangle) {
            HitBounds::Box { bounds, lean }
        } else {
            HitBounds::Degenerate(bounds)
        }
    } else {
        let lean = ((LEAN * thinness * square.sqrt()) as f32).next_up();
        let padded = bounds.padded(lean);
        // At query time, `Margin` adds a small lean to every box. Adding a large lean would widen
        // all boxes, so pad only this triangle's box instead.
        if thinness <= THIN {
            HitBounds::Box { bounds, lean }
        } else if thinness <= NEEDLE && padded.is_finite() {
            HitBounds::Box { bounds: padded, lean: 0.0 }
        } else {
            HitBounds::Thin(bounds)
        }
    }
}
