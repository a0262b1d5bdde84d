//! Three-dimensional f64 vectors, their lengths, and their distances.

use intertri::simd::Vec3;

/// A three-dimensional f64 vector: [`Vec3`] with a single lane.
pub(super) type Vec3d = Vec3<f64>;

/// Converts an f32 vector to f64.
pub(super) fn vector(p: [f32; 3]) -> Vec3d {
    Vec3d::splat(p.map(f64::from))
}

/// Returns the length of a vector.
pub(super) fn length(v: Vec3d) -> f64 {
    v.dot(v).sqrt()
}

/// Returns the distance from the coordinate origin to the segment between `p` and `q`.
pub(super) fn distance(p: Vec3d, q: Vec3d) -> f64 {
    let along = q - p;
    let square = along.dot(along);
    let s = if square > 0.0 { (-p.dot(along) / square).clamp(0.0, 1.0) } else { 0.0 };
    length(p + along * s).min(length(p)).min(length(q))
}
