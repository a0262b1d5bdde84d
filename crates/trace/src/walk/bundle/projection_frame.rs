//! Chooses the frame onto which the rays of a bundle are projected.

use intertri::internal::Frame;
use intertri::simd::Lanes;

use super::principal_axis::Spread;

/// The maximum magnitude of an origin's coordinate: 2^30.
const LARGEST: f32 = (1 << 30) as f32;

/// The maximum magnitude of a scene coordinate: 2^80. No distance from a plane then overflows.
const LARGEST_REACH: f32 = (1_u128 << 80) as f32;

/// Creates a frame that looks along `sum`. One of its axes follows the direction in which the rays
/// spread most or, if no direction stands out, `step`. Returns `None` if there is no direction, or
/// if coordinates are too large.
#[inline(always)]
pub(crate) fn frame<F: Lanes<Scalar = f32>>(
    origin: [f32; 3],
    sum: [f32; 3],
    step: [f32; 3],
    spread: &Spread<F>,
    reach: f32,
) -> Option<Frame> {
    if reach >= LARGEST_REACH || origin.iter().any(|x| x.abs() >= LARGEST) {
        return None;
    }
    let depth = unit(sum)?;
    let mut across = across(depth, step)?;
    // With an axis along the spread, the bounding rectangles of packets are tight
    // (`principal_axis`).
    if let Some(axis) = spread.principal_axis(across) {
        across = self::across(depth, axis)?;
    }
    Some(Frame::new(origin, depth, across[0], across[1]))
}

/// Returns two orthogonal axes perpendicular to `depth`. The first is as close as possible to the
/// direction of `step`.
fn across(depth: [f32; 3], step: [f32; 3]) -> Option<[[f32; 3]; 2]> {
    let along = dot(step, depth);
    let right = unit([0, 1, 2].map(|k| step[k] - along * depth[k]))
        // If the step is almost parallel to the depth axis, the remainder is small and its
        // direction is mostly rounding error.
        .filter(|right| dot(*right, depth).abs() < 1e-6)
        .or_else(|| unit(cross(depth, [1.0, 0.0, 0.0])))
        .or_else(|| unit(cross(depth, [0.0, 1.0, 0.0])))?;
    Some([right, cross(depth, right)])
}

fn dot(a: [f32; 3], b: [f32; 3]) -> f32 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

fn cross(a: [f32; 3], b: [f32; 3]) -> [f32; 3] {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

/// Returns the normalized vector, or `None` if the vector's length is almost zero or not finite.
fn unit(v: [f32; 3]) -> Option<[f32; 3]> {
    let square = dot(v, v);
    let sane = square > f32::MIN_POSITIVE * LARGEST && square < f32::MAX;
    sane.then(|| v.map(|x| x / square.sqrt()))
}
