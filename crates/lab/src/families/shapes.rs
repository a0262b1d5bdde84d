//! Families that vary the shape of the triangle and the direction of the ray.

use intertri::{Ray, Triangle};

use super::aim::{
    Point, Turn, add, aim, aimed, around, inside, nudge, round, shoot, size, soup, target, weigh,
    wide,
};
use super::scene::Scene;
use crate::rng::{Rng, step};

/// Returns a triangle with random corners in a cube with side 2 around `place`.
pub(super) fn triangle(rng: &mut Rng, place: Point) -> Triangle {
    Triangle([0; 3].map(|_| round(add(rng.cube(), place, 1.0))))
}

pub(super) fn uniform(rng: &mut Rng, _: f64, triangles: usize, rays: usize) -> Scene {
    soup(rng, triangles, rays, triangle, |rng, triangle| {
        // The ray starts near a triangle, on any side, and goes toward a point on the triangle or
        // near it.
        let to = weigh(triangle, inside(rng));
        let origin = around(rng, to, 1.0);
        let off = if rng.one_in(2) { 4.0 } else { 0.5 };
        let to = add(to, rng.cube(), off);
        Ray::new(origin, round(add(to, wide(origin), -1.0)))
    })
}

pub(super) fn random(rng: &mut Rng, _: f64, triangles: usize, rays: usize) -> Scene {
    aimed(rng, triangles, rays, triangle)
}

pub(super) fn edge_steps(rng: &mut Rng, x: f64, triangles: usize, rays: usize) -> Scene {
    let steps = (x as i32).clamp(0, 1 << 24);
    soup(rng, triangles, rays, triangle, |rng, triangle| {
        let u = rng.unit();
        let mut weights = [0.0, 1.0 - u, u];
        weights.rotate_left(rng.below(3));
        let to = weigh(triangle, weights);
        let origin = around(rng, to, size(triangle));
        let dir = round(add(to, wide(origin), -1.0));
        Ray::new(origin, dir.map(|x| step(x, rng.within(steps))))
    })
}

/// Returns a triangle `0, (1, 0, 0), (x, y, 0)` with its corners in any order. Half of these
/// triangles are rotated and moved; the other half stay in a coordinate plane at the origin, where
/// rounding preserves any ratio.
fn flat(rng: &mut Rng, place: Point, x: f64, y: f64) -> Triangle {
    let mut corners = if rng.one_in(2) {
        let turn = Turn::random(rng);
        [[0.0; 3], [1.0, 0.0, 0.0], [x, y, 0.0]].map(|p| round(turn.apply(p)))
    } else {
        let long = rng.direction();
        let other = rng.direction();
        let along = (0..3).map(|k| long[k] * other[k]).sum::<f64>();
        let short = add(other, long, -along);
        let corner = |x, y| round(add(add(place, long, x), short, y));
        [corner(0.0, 0.0), corner(1.0, 0.0), corner(x, y)]
    };
    corners.rotate_left(rng.below(3));
    if rng.one_in(2) {
        corners.swap(0, 1);
    }
    Triangle(corners)
}

pub(super) fn needle(rng: &mut Rng, x: f64, triangles: usize, rays: usize) -> Scene {
    aimed(rng, triangles, rays, |rng, place| flat(rng, place, 0.0, x))
}

pub(super) fn cap(rng: &mut Rng, x: f64, triangles: usize, rays: usize) -> Scene {
    aimed(rng, triangles, rays, |rng, place| flat(rng, place, 0.5, x))
}

pub(super) fn sliver(rng: &mut Rng, x: f64, triangles: usize, rays: usize) -> Scene {
    aimed(rng, triangles, rays, |rng, place| {
        let along = 2.0 * rng.unit();
        flat(rng, place, along, x)
    })
}

pub(super) fn zero_area(rng: &mut Rng, _: f64, triangles: usize, rays: usize) -> Scene {
    aimed(rng, triangles, rays, |rng, place| {
        let p = round(add(rng.cube(), place, 1.0));
        let q = round(add(rng.cube(), place, 1.0));
        let mut corners = match rng.below(6) {
            // All three corners coincide, possibly at the coordinate origin.
            0 => [p; 3],
            1 => [[0.0; 3]; 3],
            // Two corners coincide.
            2 => [p, p, q],
            // Corners that are collinear up to rounding.
            3 => [p, q, round(add(wide(p), add(wide(q), wide(p), -1.0), 2.0 * rng.signed()))],
            // Exactly collinear corners with full mantissas, on a line through the coordinate
            // origin, at distances whose ratios are powers of 2.
            4 => [p, p.map(|x| -2.0 * x), p.map(|x| 0.5 * x)],
            // Exactly collinear corners with small integer coordinates.
            _ => {
                let start = place.map(|x| x as i32);
                let way = [0; 3].map(|_| rng.within(4));
                [0, 1, 2]
                    .map(|k| [0, 1, 2].map(|axis| (start[axis] + [0, 1, 3][k] * way[axis]) as f32))
            }
        };
        corners.rotate_left(rng.below(3));
        Triangle(corners)
    })
}

/// Returns a triangle's two edge vectors from its first corner, and its unit normal, which is zero
/// for a triangle with zero area.
fn frame(triangle: &Triangle) -> [Point; 3] {
    let [a, b, c] = triangle.0.map(wide);
    let (p, q) = (add(b, a, -1.0), add(c, a, -1.0));
    let n = [p[1] * q[2] - p[2] * q[1], p[2] * q[0] - p[0] * q[2], p[0] * q[1] - p[1] * q[0]];
    let length = (n[0] * n[0] + n[1] * n[1] + n[2] * n[2]).sqrt();
    [p, q, n.map(|x| if length > 0.0 { x / length } else { 0.0 })]
}

/// Returns a random triangle exactly in a coordinate plane.
fn in_plane(rng: &mut Rng) -> Triangle {
    let turn = Turn::random(rng);
    Triangle([0; 3].map(|_| round(turn.apply([rng.signed(), rng.signed(), 0.0]))))
}

pub(super) fn grazing(rng: &mut Rng, x: f64, triangles: usize, rays: usize) -> Scene {
    // Half of the triangles are in a coordinate plane, where rounding preserves any angle.
    let shape = |rng: &mut Rng, place| {
        if rng.one_in(2) { in_plane(rng) } else { triangle(rng, place) }
    };
    soup(rng, triangles, rays, shape, |rng, triangle| {
        let [p, q, n] = frame(triangle);
        let way = add(add(p.map(|x| x * rng.signed()), q, rng.signed()), n, x);
        let to = weigh(triangle, target(rng));
        let origin = round(add(to, way, -rng.log(0.25, 16.0)));
        let dir = if rng.one_in(2) { round(way) } else { round(add(to, wide(origin), -1.0)) };
        Ray::new(origin, nudge(rng, dir))
    })
}

pub(super) fn coplanar(rng: &mut Rng, _: f64, triangles: usize, rays: usize) -> Scene {
    let shape = |rng: &mut Rng, place| {
        if rng.one_in(2) { in_plane(rng) } else { triangle(rng, place) }
    };
    soup(rng, triangles, rays, shape, |rng, triangle| {
        let [p, q, _] = frame(triangle);
        let to = weigh(triangle, target(rng));
        let way = add(p.map(|x| x * rng.signed()), q, rng.signed());
        let origin = round(add(to, way, rng.log(0.25, 4.0)));
        let dir = round(add(to, wide(origin), -1.0));
        Ray::new(origin, if rng.one_in(2) { dir } else { nudge(rng, dir) })
    })
}

pub(super) fn far(rng: &mut Rng, x: f64, triangles: usize, rays: usize) -> Scene {
    soup(rng, triangles, rays, triangle, |rng, triangle| {
        let to = weigh(triangle, target(rng));
        let away = rng.direction();
        let origin = round(add(to, away, x * size(triangle)));
        shoot(rng, origin, to)
    })
}

pub(super) fn tiny(rng: &mut Rng, x: f64, triangles: usize, rays: usize) -> Scene {
    let shape = |rng: &mut Rng, place: Point| {
        let centre = add(place, rng.direction(), 1.0);
        Triangle([0; 3].map(|_| round(add(centre, rng.cube(), x))))
    };
    soup(rng, triangles, rays, shape, |rng, triangle| {
        let to = weigh(triangle, target(rng));
        let origin = around(rng, to, 1.0);
        shoot(rng, origin, to)
    })
}

pub(super) fn on_triangle(rng: &mut Rng, _: f64, triangles: usize, rays: usize) -> Scene {
    soup(rng, triangles, rays, triangle, |rng, triangle| {
        let from = round(weigh(triangle, target(rng)));
        let origin = if rng.one_in(2) { from } else { nudge(rng, from) };
        Ray::new(origin, round(rng.direction()))
    })
}

pub(super) fn stack(rng: &mut Rng, _: f64, triangles: usize, rays: usize) -> Scene {
    let bottom = triangle(rng, [0.0; 3]);
    let steps = rng.pick(&[0, 1, 2, 1000]);
    let shape = |rng: &mut Rng, _| {
        // Use the same corners in another order, usually moved by a few steps.
        let mut corners = bottom.0;
        if !rng.one_in(3) {
            corners = corners.map(|p| p.map(|x| step(x, rng.within(steps))));
        }
        corners.rotate_left(rng.below(3));
        if rng.one_in(4) {
            corners.swap(0, 1);
        }
        Triangle(corners)
    };
    soup(rng, triangles, rays, shape, aim)
}

pub(super) fn axis(rng: &mut Rng, _: f64, triangles: usize, rays: usize) -> Scene {
    let shape = |rng: &mut Rng, place: Point| {
        // Half of the triangles are perpendicular to an axis, so their bounding boxes are flat.
        let thin = rng.below(6);
        let level = rng.within(4);
        let integer = |rng: &mut Rng, axis| {
            let x = if axis == thin { level } else { rng.within(4) };
            (place[axis] as i32 + x) as f32
        };
        Triangle([0; 3].map(|_| [0, 1, 2].map(|axis| integer(rng, axis))))
    };
    soup(rng, triangles, rays, shape, |rng, triangle| {
        // The ray passes through a corner or halfway between two corners, and starts an integer
        // multiple of its direction away.
        let (p, q) = (rng.pick(&triangle.0), rng.pick(&triangle.0));
        let to = [0, 1, 2].map(|k| f32::midpoint(p[k], q[k]));
        let mut dir = [0; 3].map(|_| rng.pick(&[-2.0, -1.0, 0.0, 0.0, 0.0, -0.0, 1.0]));
        dir[rng.below(3)] = rng.pick(&[-1.0, 1.0]);
        let away = rng.pick(&[0.0, 1.0, 3.0, 8.0]);
        Ray::new([0, 1, 2].map(|k| to[k] - away * dir[k]), dir)
    })
}
