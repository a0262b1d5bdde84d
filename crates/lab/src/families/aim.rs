//! Aims rays at points of a triangle where rounding can change the result.

use intertri::{Ray, Triangle};
use intertri_reference::inter_tri::THRESHOLD;

use super::scene::Scene;
use crate::rng::{Rng, step};

/// A point or direction under construction, which is rounded to f32 at the end.
pub(super) type Point = [f64; 3];

pub(super) fn add(a: Point, b: Point, scale: f64) -> Point {
    [a[0] + b[0] * scale, a[1] + b[1] * scale, a[2] + b[2] * scale]
}

pub(super) fn round(a: Point) -> [f32; 3] {
    a.map(|x| x as f32)
}

pub(super) fn wide(a: [f32; 3]) -> Point {
    a.map(f64::from)
}

/// A permutation of a vector's components, combined with sign changes. Applying it never rounds.
#[derive(Clone, Copy)]
pub(super) struct Turn([usize; 3], [f64; 3]);

impl Turn {
    pub(super) fn random(rng: &mut Rng) -> Self {
        let order = rng.pick(&[[0, 1, 2], [0, 2, 1], [1, 0, 2], [1, 2, 0], [2, 0, 1], [2, 1, 0]]);
        Self(order, [0; 3].map(|_| rng.pick(&[-1.0, 1.0])))
    }

    pub(super) fn apply(self, a: Point) -> Point {
        [a[self.0[0]] * self.1[0], a[self.0[1]] * self.1[1], a[self.0[2]] * self.1[2]]
    }
}

/// Returns the longest side of a triangle's bounding box. If all corners coincide, returns the
/// largest absolute coordinate, but at least 1e-30.
pub(super) fn size(triangle: &Triangle) -> f64 {
    let [a, b, c] = triangle.0.map(wide);
    let mut size = 0.0_f64;
    for k in 0..3 {
        size = size.max(a[k].max(b[k]).max(c[k]) - a[k].min(b[k]).min(c[k]));
    }
    if size > 0.0 { size } else { a.iter().fold(0.0, |m: f64, x| m.max(x.abs())).max(1e-30) }
}

/// Returns the point in a triangle's plane with the given barycentric weights.
pub(super) fn weigh(triangle: &Triangle, weights: Point) -> Point {
    let [a, b, c] = triangle.0.map(wide);
    [0, 1, 2].map(|k| a[k] * weights[0] + b[k] * weights[1] + c[k] * weights[2])
}

/// Returns the weights of a random point inside the triangle.
pub(super) fn inside(rng: &mut Rng) -> Point {
    let (u, v) = (rng.unit(), rng.unit());
    let (u, v) = if u + v <= 1.0 { (u, v) } else { (1.0 - u, 1.0 - v) };
    [1.0 - u - v, u, v]
}

/// Returns the weights of a random point in the triangle's plane. On average, of every 16 points,
/// eight are on an edge, three at a vertex, three inside, one near an edge on either side (at a
/// weight of 1e-9 to 1), and one at a random position in the plane.
pub(super) fn target(rng: &mut Rng) -> Point {
    let mut weights = match rng.below(16) {
        0..=7 => {
            let u = if rng.one_in(8) { 0.5 } else { rng.unit() };
            [0.0, 1.0 - u, u]
        }
        8..=10 => [1.0, 0.0, 0.0],
        11..=13 => inside(rng),
        14 => {
            let (u, off) = (rng.unit(), rng.log(1e-9, 1.0) * rng.pick(&[-1.0, 1.0]));
            [off, (1.0 - off) * (1.0 - u), (1.0 - off) * u]
        }
        _ => {
            let (u, v) = (3.0 * rng.signed(), 3.0 * rng.signed());
            [1.0 - u - v, u, v]
        }
    };
    weights.rotate_left(rng.below(3));
    weights
}

/// Moves a direction by a few f32 steps, mostly up to 3 in each component and sometimes up to about
/// 1000, so that the edge values cover every size that an error bound could have.
pub(super) fn nudge(rng: &mut Rng, dir: [f32; 3]) -> [f32; 3] {
    let steps = match rng.below(8) {
        0 => 0,
        1 => 1 << rng.below(11),
        _ => 3,
    };
    dir.map(|x| step(x, rng.within(steps)))
}

/// Returns a nudged ray from one point toward another. The direction's length is approximately
/// either the distance between the points or 1.
pub(super) fn shoot(rng: &mut Rng, origin: [f32; 3], to: Point) -> Ray {
    let way = add(to, wide(origin), -1.0);
    let longest = way.iter().fold(0.0, |m: f64, x| m.max(x.abs()));
    let length = if longest > 0.0 && rng.one_in(2) { longest } else { 1.0 };
    Ray::new(origin, nudge(rng, round(way.map(|x| x / length))))
}

/// Returns a random point at a distance of a quarter to 16 times `size` from a target.
pub(super) fn around(rng: &mut Rng, target: Point, size: f64) -> [f32; 3] {
    let away = rng.direction();
    round(add(target, away, size * rng.log(0.25, 16.0)))
}

/// Returns a ray toward a point chosen by [`target`], from a random side.
pub(super) fn aim(rng: &mut Rng, triangle: &Triangle) -> Ray {
    let to = weigh(triangle, target(rng));
    let origin = around(rng, to, size(triangle));
    shoot(rng, origin, to)
}

/// Builds a scene of triangles and rays. The triangles are built around random points in a cube
/// that grows with their number (the first triangle around 0), and each ray is built for one of the
/// triangles.
pub(super) fn soup(
    rng: &mut Rng,
    triangles: usize,
    rays: usize,
    mut shape: impl FnMut(&mut Rng, Point) -> Triangle,
    mut ray: impl FnMut(&mut Rng, &Triangle) -> Ray,
) -> Scene {
    let mut spread = 1;
    while spread * spread * spread < triangles {
        spread += 1;
    }
    let triangles: Vec<_> = (0..triangles)
        .map(|i| {
            let place = if i == 0 { [0.0; 3] } else { rng.cube().map(|x| x * spread as f64) };
            shape(rng, place)
        })
        .collect();
    let rays = (0..rays)
        .filter(|_| !triangles.is_empty())
        .map(|_| {
            let triangle = rng.pick(&triangles);
            ray(rng, &triangle)
        })
        .collect();
    Scene { triangles, rays, threshold: THRESHOLD }
}

/// Builds a soup with rays from [`aim`]. In a quarter of the scenes, the rays share their origin.
pub(super) fn aimed(
    rng: &mut Rng,
    triangles: usize,
    rays: usize,
    shape: impl FnMut(&mut Rng, Point) -> Triangle,
) -> Scene {
    let share = rng.one_in(4);
    let mut eye = None;
    soup(rng, triangles, rays, shape, |rng, triangle| match eye {
        Some(eye) if share => {
            let to = weigh(triangle, target(rng));
            shoot(rng, eye, to)
        }
        _ => {
            let ray = aim(rng, triangle);
            eye = Some(ray.origin);
            ray
        }
    })
}
