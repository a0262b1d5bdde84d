//! The position of a corner relative to a point, split into components along the rays that count
//! crossings and components perpendicular to them.

use intertri::Scalar;
use intertri::internal::exact::moment;

use super::classify::WINDING_DIR;

/// If the square of the ratio of a corner's distance from the ray to its distance along the ray is
/// below this, the corner's direction from the ray is computed exactly.
const NEAR_RAY: f64 = 1.0 / (1_u64 << 60) as f64;

/// The range of magnitudes whose products neither overflow nor underflow.
const TAME: [f64; 2] = [pow2(-300), pow2(300)];

/// Returns `2^e`, which must be a normal number.
const fn pow2(e: i32) -> f64 {
    f64::from_bits(((1023 + e) as u64) << 52)
}

/// The direction of the rays and two directions perpendicular to it.
#[derive(Clone, Copy, Debug)]
pub(super) struct Axes(pub(super) [[f64; 3]; 3]);

/// A corner relative to a point, up to a positive factor.
#[derive(Clone, Copy)]
pub(super) struct SeenCorner {
    /// The components perpendicular to the ray.
    pub(super) across: [f64; 2],
    /// The distance from the point minus the component along the ray.
    pub(super) excess: f64,
    /// The distance from the point.
    pub(super) size: f64,
}

impl Axes {
    pub(super) fn new() -> Self {
        let d = unit(WINDING_DIR.map(f64::from));
        // Any direction that is not parallel to the rays will do.
        let e = unit(cross(d, [1.0, 0.0, 0.0]));
        Self([d, e, cross(d, e)])
    }

    /// Computes the position of a corner relative to a point.
    #[inline(always)]
    pub(super) fn seen<S: Scalar>(&self, point: [S; 3], corner: [S; 3]) -> SeenCorner {
        let [p, c] = [point, corner].map(|v| v.map(Into::<f64>::into));
        let mut v = [c[0] - p[0], c[1] - p[1], c[2] - p[2]];
        let most = v[0].abs().max(v[1].abs()).max(v[2].abs());
        if !(TAME[0]..=TAME[1]).contains(&most) {
            v = scaled(c, p);
        }
        let [z, x, y] = self.0.map(|axis| dot(axis, v));
        let beside = x * x + y * y;
        let size = (z * z + beside).sqrt();
        if z > 0.0 && beside < NEAR_RAY * z * z {
            return self.near(point, corner, 0.5 * beside.sqrt() / size);
        }
        let excess = if z > 0.0 { beside / (size + z) } else { size - z };
        SeenCorner { across: [x, y], excess, size }
    }

    /// Handles a corner on or near the ray: computes its direction from the ray exactly. `half` is
    /// half the angle between the ray and the direction to the corner.
    #[cold]
    #[inline(never)]
    fn near<S: Scalar>(&self, point: [S; 3], corner: [S; 3], half: f64) -> SeenCorner {
        let turn = moment(point, WINDING_DIR.map(S::from), corner);
        let [_, x, y] = self.0.map(|axis| dot(axis, turn));
        let size = x.hypot(y);
        SeenCorner { across: [y / size, -x / size], excess: half, size: 1.0 }
    }
}

/// Returns a vector in the direction of `c - p`, scaled so that its products stay in range, or 0 if
/// `c` and `p` are equal.
#[cold]
fn scaled(c: [f64; 3], p: [f64; 3]) -> [f64; 3] {
    let small = [0, 1, 2].map(|k| c[k] - p[k]);
    if small.iter().all(|x| x.abs() < 1.0) {
        return small.map(|x| x * pow2(690));
    }
    // The difference between two of the largest f64 values overflows, but the difference between
    // their quarters does not.
    [0, 1, 2].map(|k| (0.25 * c[k] - 0.25 * p[k]) * pow2(-660))
}

#[inline(always)]
fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

fn cross(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

fn unit(v: [f64; 3]) -> [f64; 3] {
    let size = dot(v, v).sqrt();
    v.map(|x| x / size)
}
