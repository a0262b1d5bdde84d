//! Selects cases whose rays pass well clear of all edges.

use crate::families::Case;

/// Returns whether a ray avoids everything that is difficult by design: it meets the plane in front
/// of its origin, at least a hundredth of the triangle's size away from every side, whether inside
/// or outside. A failure on such a ray is due to the triangle's shape or the magnitude of its
/// coordinates, not to a rounding error in the last bit.
pub(super) fn is_clear(case: &Case) -> bool {
    let wide = |p: [f32; 3]| p.map(f64::from);
    let sub = |a: [f64; 3], b: [f64; 3]| [a[0] - b[0], a[1] - b[1], a[2] - b[2]];
    let dot = |a: [f64; 3], b: [f64; 3]| a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
    let cross = |a: [f64; 3], b: [f64; 3]| {
        [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
    };
    // The coordinates are taken relative to a corner first, so the error in f64 is far below the
    // margin of 0.01.
    let [c1, c2, c3] = case.triangle.0.map(wide);
    let (a, d) = (sub(c1, wide(case.ray.origin)), wide(case.ray.dir));
    let (h4, h5) = (sub(c2, c1), sub(c3, c1));
    let (r, n) = (cross(d, a), cross(h4, h5));
    let den = dot(n, d);
    let (v, w) = (-dot(h5, r) / den, dot(h4, r) / den);
    let u = 1.0 - v - w;
    let inside = u > 0.01 && v > 0.01 && w > 0.01;
    let outside = u < -0.01 || v < -0.01 || w < -0.01;
    dot(n, a) / den > 0.0 && (inside || outside) && u.abs() < 1e3 && v.abs() < 1e3
}
