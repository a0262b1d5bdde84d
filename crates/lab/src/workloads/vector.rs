//! Operations on three-dimensional f64 vectors.

pub(super) fn add(a: [f64; 3], b: [f64; 3], scale: f64) -> [f64; 3] {
    [a[0] + b[0] * scale, a[1] + b[1] * scale, a[2] + b[2] * scale]
}

pub(super) fn cross(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

pub(super) fn length([x, y, z]: [f64; 3]) -> f64 {
    (x * x + y * y + z * z).sqrt()
}

pub(super) fn distance(a: [f64; 3], b: [f64; 3]) -> f64 {
    length(add(a, b, -1.0))
}

/// Returns the unit vector in the direction of `a`. A vector of length 0 is returned unchanged.
pub(super) fn unit(a: [f64; 3]) -> [f64; 3] {
    let length = length(a);
    if length > 0.0 { a.map(|x| x / length) } else { a }
}

pub(super) fn round(a: [f64; 3]) -> [f32; 3] {
    a.map(|x| x as f32)
}
