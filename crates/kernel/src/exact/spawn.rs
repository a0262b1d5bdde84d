//! Creates rays that start at a hit on a triangle, without a tuned epsilon.
//!
//! ```text
//!            ╱ dir                 The rounded hit point may be on either side of the plane. If
//!      ●    ╱                      dir leads through the plane from there, the point is moved
//!   ───┼───╱──────── plane         along the axis nearest to the normal, by a few units in the
//!      ○                           last place, until dir no longer does.
//! ```
//!
//! `docs/numerics/exact.md`, section 9, has the derivation.

use core::cmp::Ordering;

use bytemuck::cast;

use super::float;
use super::input::{is_finite, is_plain};
use super::numbers::Pair;
use super::tier::is_f64;
use crate::simd::Vec3;
use crate::{Hit, Ray, Ray64, RayOf, Scalar, Triangle, Triangle64, TriangleOf};

/// Returns a ray that starts at a hit on a triangle and has the direction `dir`. In
/// [`Mode::exact`](crate::Mode::exact), the ray never hits that triangle, whatever its direction.
///
/// The ray starts at the point with the hit's weights, rounded to the scalar type, or next to that
/// point on the side to which `dir` leads. Along each axis, the start differs from the true point
/// by at most six ulps of the point's largest coordinate or `2^-46` times the triangle's largest
/// coordinate, whichever is larger. The ray may miss anything that is nearer than that. The
/// difference may be larger if the weights do not come from [`Mode::exact`](crate::Mode::exact).
/// The ray's interval is `t > 0`. Near an edge, the ray may hit the triangle on the other side of
/// the edge. To test whether two points see each other, use `Bvh::visible` from `intertri-trace`.
///
/// If `hit` is a miss, or if no start can be found, the origin is NaN, and the ray hits nothing,
/// whatever its interval.
///
/// ```
/// use intertri::{Mode, Ray, Triangle, spawn_ray};
/// let slope = Triangle::new([0.0, 0.1, 0.3], [7.0, 0.2, 0.4], [0.3, 6.0, 1.7]);
/// let ray = Ray::new([1.3, 1.1, 9.0], [0.1, 0.07, -1.0]);
/// let hit = Mode::exact().closest(&[slope], &ray).unwrap();
/// for dir in [[0.0, 0.3, 1.0], [0.0, 0.3, -1.0]] {
///     let next = spawn_ray(&hit, &slope, dir);
///     assert!(!Mode::exact().any(&[slope], &next));
///     assert!((0..3).all(|k| (f64::from(next.origin[k]) - hit.point(&ray)[k]).abs() < 1e-6));
/// }
/// ```
pub fn spawn_ray<S: Scalar>(hit: &Hit, triangle: &TriangleOf<S>, dir: [S; 3]) -> RayOf<S> {
    // Both functions are compiled in this crate; generic code would be compiled with the caller's
    // profile.
    if const { is_f64::<S>() } {
        cast(spawn_f64(hit, &cast(*triangle), cast(dir)))
    } else {
        cast(spawn_f32(hit, &cast(*triangle), cast(dir)))
    }
}

fn spawn_f32(hit: &Hit, triangle: &Triangle, dir: [f32; 3]) -> Ray {
    spawn(hit, triangle, dir)
}

fn spawn_f64(hit: &Hit, triangle: &Triangle64, dir: [f64; 3]) -> Ray64 {
    spawn(hit, triangle, dir)
}

fn spawn<S: Scalar>(hit: &Hit, triangle: &TriangleOf<S>, dir: [S; 3]) -> RayOf<S> {
    let point = point_of(hit, triangle);
    let start = RayOf::new(point.map(S::nearest), dir);
    let nowhere = RayOf::new([S::nearest(f64::NAN); 3], dir);

    if !hit.is_hit() || !is_finite(&start, triangle) {
        return nowhere;
    }
    let (plane, side) = signs(&start, triangle);
    if goes_away(plane, side) {
        return start;
    }

    // `unit` must exceed the error of any coordinate.
    let largest = |v: [f64; 3]| v[0].abs().max(v[1].abs()).max(v[2].abs());
    let corners = triangle.0.map(|corner| largest(corner.map(Into::into)));
    // The unit in the last place of the largest coordinate, or, if larger, `2^-49` times the
    // triangle's largest coordinate, which covers the rounding of the weights (exact.md, section
    // 9).
    let last_place = largest(point) / (1_u64 << (S::DIGITS - 1)) as f64 + S::LEAST_NORMAL;
    let unit = last_place.max(largest(corners) / (1_u64 << 49) as f64);

    // Move along the axis nearest to the normal, to the side to which the direction leads. If f64
    // cannot determine the normal, another axis or the opposite sign may be the right choice.
    let normal = normal(triangle);
    let mut axes = [0, 1, 2];
    axes.sort_unstable_by(|&a, &b| normal[b].abs().total_cmp(&normal[a].abs()).then(a.cmp(&b)));
    for axis in axes {
        let way = if (side == Ordering::Less) == (normal[axis] < 0.0) { unit } else { -unit };
        // The first choice works unless the normal is too inaccurate in f64. In that case, try the
        // opposite sign and then the other axes.
        for step in [way, -way] {
            if let Some(next) = moved(&start, point, (axis, step), triangle) {
                return next;
            }
        }
    }
    nowhere
}

/// Returns a ray from a hit on a triangle to a target at `t = 1`. This is [`spawn_ray`] with the
/// interval `0 < t < 1`, for shadow rays to a light.
///
/// The distance between the end of the ray and the target has the same bound as the distance
/// between the start and the hit, plus the rounding error of the direction.
///
/// ```
/// use intertri::{Mode, Ray, Triangle, spawn_ray_to};
/// let floor = Triangle::new([-9.0, 0.1, -9.0], [9.0, 0.2, -9.0], [0.0, 0.3, 9.0]);
/// let hit = Mode::exact().closest(&[floor], &Ray::new([0.3, 5.0, 0.1], [0.1, -1.0, 0.2])).unwrap();
/// let to_light = spawn_ray_to(&hit, &floor, [3.0, 7.0, 1.0]);
/// assert!(!Mode::exact().any(&[floor], &to_light));
/// // Objects behind the light cast no shadow.
/// assert_eq!(to_light.t_max, 1.0);
/// ```
pub fn spawn_ray_to<S: Scalar>(hit: &Hit, triangle: &TriangleOf<S>, target: [S; 3]) -> RayOf<S> {
    let point = point_of(hit, triangle);
    let toward = [0, 1, 2].map(|k| S::nearest(target[k].into() - point[k]));
    spawn_ray(hit, triangle, toward).between(S::ZERO, S::ONE)
}

/// Computes the point on a triangle that has the hit's weights.
fn point_of<S: Scalar>(hit: &Hit, triangle: &TriangleOf<S>) -> [f64; 3] {
    let first = (1.0 - hit.u) - hit.v;
    [0, 1, 2].map(|k| {
        let [a, b, c]: [f64; 3] = triangle.0.map(|corner| corner[k].into());
        (first * a + hit.u * b) + hit.v * c
    })
}

/// Moves the ray's origin along an axis until the ray leads away from the triangle. Along the axis
/// nearest to the normal, four steps are always enough if the hit's weights are correctly rounded;
/// otherwise, more may be needed. Returns `None` if 2^39 steps are not enough.
fn moved<S: Scalar>(
    start: &RayOf<S>,
    point: [f64; 3],
    (axis, step): (usize, f64),
    triangle: &TriangleOf<S>,
) -> Option<RayOf<S>> {
    let mut next = *start;
    for doublings in 0..40 {
        // Start from the point, not from the last attempt, so that rounding errors do not
        // accumulate.
        let steps = (1_u64 << doublings) as f64;
        next.origin[axis] = S::nearest(point[axis] + steps * step);
        if !is_finite(&next, triangle) {
            return None;
        }
        let (plane, side) = signs(&next, triangle);
        if goes_away(plane, side) {
            return Some(next);
        }
    }
    None
}

/// Returns a triangle's normal, which may have any length. f64 can represent the normal of every
/// f32 triangle, but not of every f64 triangle. For f64, the edges start at the corner opposite the
/// longest edge, because the differences between a distant corner and two corners that are close
/// together may round to the same vector.
fn normal<S: Scalar>(triangle: &TriangleOf<S>) -> [f64; 3] {
    if const { !is_f64::<S>() } {
        return triangle.normal();
    }
    let corners: [[f64; 3]; 3] = triangle.0.map(|corner| corner.map(Into::into));
    // Halve the coordinates first, because a difference may be too large for f64.
    let edge = |a: usize, b: usize| [0, 1, 2].map(|k| 0.5 * corners[b][k] - 0.5 * corners[a][k]);
    let length = |edge: [f64; 3]| edge.iter().fold(f64::MIN_POSITIVE, |most, x| most.max(x.abs()));
    let long = [0, 1, 2].map(|i| length(edge((i + 1) % 3, (i + 2) % 3)));
    let at = (0..3).fold(0, |a, b| if long[b] > long[a] { b } else { a });
    let unit = |edge: [f64; 3]| edge.map(|x| x / length(edge));
    let ([x, y, z], [u, v, w]) = (unit(edge(at, (at + 1) % 3)), unit(edge(at, (at + 2) % 3)));
    [y * w - z * v, z * u - x * w, x * v - y * u]
}

/// Returns whether a ray starts in a triangle's plane, leads away from the plane, or is parallel to
/// the plane.
fn goes_away(plane: Ordering, side: Ordering) -> bool {
    plane != side || side == Ordering::Equal
}

/// Returns the signs of T and D.
fn signs<S: Scalar>(ray: &RayOf<S>, triangle: &TriangleOf<S>) -> (Ordering, Ordering) {
    if is_plain(ray, triangle) {
        let vec3 = |v: [S; 3]| Vec3::<f64>::splat(v.map(Into::into));
        let corners = triangle.0.map(vec3);
        if let Some(signs) = float::plane_signs(corners, vec3(ray.origin), vec3(ray.dir)) {
            return signs;
        }
    }
    Pair::new(ray, triangle).plane_signs()
}
