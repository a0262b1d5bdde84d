//! The scalar reference in i128: the test of one ray against one triangle, in its simplest form.
//!
//! Let A, B, and C be the corners relative to the origin, and let d be the direction. The ray's
//! line passes through the inside of the triangle if the three determinants
//!
//! ```text
//!   U = d . (B x C)      V = d . (C x A)      W = d . (A x B)
//! ```
//!
//! have the same sign. The line meets the plane at `t = A . (B x C) / (U + V + W)`.

use super::{Crossing, Ratio, Ray, Triangle};

/// Returns where a ray crosses a triangle, or `None` if it does not.
///
/// The complete rule is as follows. A determinant that is 0 takes the sign of the first nonzero
/// component of its cross product. The ray crosses if the three signs and the sign of `A . (B x C)`
/// are equal and nonzero, and if `t_min <= t < t_max`.
///
/// ```
/// use intertri::fixed::{Bits, Grid, scalar};
/// let grid = Grid::at(Bits::FINE, 0, [0; 3])?;
/// let wall = grid.triangle_of([[0, 0, 5], [4, 0, 5], [0, 4, 5]])?;
/// assert!(scalar::crossing(&grid.ray_of([1, 1, 0], [0, 0, 1])?, &wall).is_some());
/// assert!(scalar::crossing(&grid.ray_of([1, 1, 0], [0, 0, -1])?, &wall).is_none());
/// # Ok::<_, intertri::fixed::GridError>(())
/// ```
pub fn crossing(ray: &Ray, triangle: &Triangle) -> Option<Crossing> {
    let d = ray.dir().map(i128::from);
    let [a, b, c] = triangle
        .0
        .map(|corner| [0, 1, 2].map(|i| i128::from(corner[i]) - i128::from(ray.origin()[i])));

    let normals = [cross(b, c), cross(c, a), cross(a, b)];
    let volume = dot(a, normals[0]);
    let sign = volume.signum();
    if sign == 0 || normals.iter().any(|&n| perturbed_sign(d, n) != sign) {
        return None;
    }

    let [u, v, w] = normals.map(|n| dot(d, n).unsigned_abs() as u64);
    let t = Ratio { num: volume.unsigned_abs(), den: u + v + w };
    let crossing = Crossing { t, v, w, leaves: sign > 0 };
    t.within(ray.to_f32()).then_some(crossing)
}

/// Returns the sign of `(d + (e, e^2, e^3)) . n` for an arbitrarily small e.
fn perturbed_sign(d: [i128; 3], n: [i128; 3]) -> i128 {
    [dot(d, n), n[0], n[1], n[2]].into_iter().map(i128::signum).find(|&s| s != 0).unwrap_or(0)
}

fn dot(a: [i128; 3], b: [i128; 3]) -> i128 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

fn cross(a: [i128; 3], b: [i128; 3]) -> [i128; 3] {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}
