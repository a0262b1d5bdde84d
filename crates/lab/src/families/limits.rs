//! Families whose rays are within a few floating-point steps of a limit: the `Threshold` or an end
//! of the interval of `t`.

use intertri::{Ray, Triangle};
use intertri_reference::{Ray as F64Ray, Scene as F64Scene, THRESHOLD, Vector};

use super::aim::{Point, Turn, add, aim, inside, nudge, round, soup, weigh};
use super::scene::Scene;
use super::shapes::{random, triangle};
use crate::rng::{Rng, step, step64};

/// Returns the unit normal of a triangle, as document A computes it.
fn normal(triangle: &Triangle) -> Point {
    F64Scene::from_triangles([triangle.0]).trian[0].nrm.into()
}

/// Returns `|vd|` and `t` for a ray and a triangle, or NaN if undefined. `vd` is the dot product of
/// the normal and the direction.
fn vd_and_t(triangle: &Triangle, ray: &Ray) -> (f64, f64) {
    let scene = F64Scene::from_triangles([triangle.0]).with_threshold(0.0);
    let vd = scene.trian[0].nrm & Vector::from(ray.dir);
    let mut t = f64::NAN;
    scene.inter_tri(0, &F64Ray::new(ray.origin, ray.dir), &mut t);
    // The sign of a NaN differs between CPUs.
    (vd.abs(), if t.is_nan() { f64::NAN } else { t })
}

/// Returns the axis of the largest component of a normal.
fn longest(n: Point) -> usize {
    let [x, y, z] = n.map(f64::abs);
    if x >= y && x >= z {
        0
    } else if y >= z {
        1
    } else {
        2
    }
}

/// Returns a direction whose dot product with the normal is within a few f64 steps of `vd`. Its
/// component along the normal's longest axis determines the first 24 bits, the second component the
/// next bits, and the third component the last bits.
fn solve(n: Point, vd: f64) -> [f32; 3] {
    let mut dir = [0.0_f32; 3];
    let mut rest = vd;
    for k in 0..3 {
        let axis = (longest(n) + k) % 3;
        if n[axis] == 0.0 {
            continue;
        }
        dir[axis] = (rest / n[axis]) as f32;
        rest -= n[axis] * f64::from(dir[axis]);
    }
    dir
}

pub(super) fn threshold_vd(rng: &mut Rng, x: f64, triangles: usize, rays: usize) -> Scene {
    // If the triangles are in a coordinate plane, `vd` is exactly a component of `dir`. The
    // threshold is rounded to f32, so that `vd` can equal it.
    let flat = rng.one_in(2);
    let threshold = if flat { f64::from(x as f32) } else { x };
    let turn = Turn::random(rng);
    let mut scene = if flat {
        let shape = |rng: &mut Rng, _| {
            Triangle([0; 3].map(|_| round(turn.apply([rng.signed(), rng.signed(), 0.0]))))
        };
        soup(rng, triangles, rays, shape, |rng, triangle| {
            let vd = f64::from(step(threshold as f32, rng.within(2))) * rng.pick(&[-1.0, 1.0]);
            let way = turn.apply([rng.signed(), rng.signed(), vd]);
            let to = weigh(triangle, inside(rng));
            Ray::new(round(add(to, way, -rng.log(0.5, 4.0))), round(way))
        })
    } else {
        soup(rng, triangles, rays, triangle, |rng, triangle| {
            let n = normal(triangle);
            let dir = solve(n, step64(threshold, rng.within(3)) * rng.pick(&[-1.0, 1.0]));
            let to = weigh(triangle, inside(rng));
            Ray::new(round(add(to, dir.map(f64::from), -1.0 / threshold)), dir)
        })
    };
    scene.threshold = threshold;
    scene
}

pub(super) fn threshold_t(rng: &mut Rng, x: f64, triangles: usize, rays: usize) -> Scene {
    let mut scene = soup(rng, triangles, rays, triangle, |rng, triangle| {
        // The ray starts at some distance along the normal's longest axis. Solve for a direction
        // whose `vd` makes t equal to the threshold.
        let n = normal(triangle);
        let axis = longest(n);
        let mut origin = weigh(triangle, inside(rng));
        origin[axis] += rng.log(0.25, 4.0) * rng.pick(&[-1.0, 1.0]);
        let origin = round(origin);
        let c1 = triangle.0[0];
        let rise = Vector::from(n) & (Vector::from(c1) - Vector::from(origin));
        Ray::new(origin, solve(n, rise / step64(x, rng.within(3))))
    });
    scene.threshold = x;
    scene
}

pub(super) fn threshold_default(rng: &mut Rng, _: f64, triangles: usize, rays: usize) -> Scene {
    if rng.one_in(2) {
        let mut scene = threshold_vd(rng, THRESHOLD, triangles, rays);
        scene.threshold = THRESHOLD;
        scene
    } else {
        threshold_t(rng, THRESHOLD, triangles, rays)
    }
}

pub(super) fn threshold_met(rng: &mut Rng, _: f64, triangles: usize, rays: usize) -> Scene {
    let mut scene = random(rng, 1.0, triangles, rays);
    // Aim the first ray at the first triangle, and use the pair's `vd` or t as the threshold.
    if let (Some(triangle), Some(first)) = (scene.triangles.first(), scene.rays.first_mut()) {
        *first = aim(rng, triangle);
        // A longer direction makes t smaller than `vd`, so that the comparison of t with the
        // threshold decides.
        if rng.one_in(2) {
            first.dir = first.dir.map(|x| 64.0 * x);
        }
        let (vd, t) = vd_and_t(triangle, first);
        let limit = step64(vd.min(t), rng.within(2));
        if limit.is_finite() && limit >= 0.0 {
            scene.threshold = limit;
        }
    }
    scene
}

pub(super) fn interval(rng: &mut Rng, _: f64, triangles: usize, rays: usize) -> Scene {
    // In half of the scenes, heights and distances are small round numbers, so that many values of
    // t are exact in f32. With full mantissas, hardly any value would be exact.
    let whole = rng.one_in(2);
    let turn = Turn::random(rng);
    let shape = |rng: &mut Rng, place| {
        if !whole {
            return triangle(rng, place);
        }
        let height = rng.within(8) as f64;
        Triangle([0; 3].map(|_| round(turn.apply([rng.signed(), rng.signed(), height]))))
    };
    soup(rng, triangles, rays, shape, |rng, triangle| {
        let ray = if whole {
            let rise = rng.pick(&[-2.0, -1.0, 0.5, 1.0]);
            let way = round(turn.apply([rng.signed(), rng.signed(), rise])).map(f64::from);
            let away = rng.pick(&[1.0, 2.0, 3.0]);
            Ray::new(round(add(weigh(triangle, inside(rng)), way, -away)), round(way))
        } else {
            aim(rng, triangle)
        };
        let (_, t) = vd_and_t(triangle, &ray);
        let near = step(t as f32, rng.within(1));
        let (t_min, t_max) = match rng.below(12) {
            0..=3 => (near, f32::INFINITY),
            4..=7 => (0.0, near),
            8 => (near, step(near, rng.within(2))),
            9 => (f32::NEG_INFINITY, nudge(rng, [near; 3])[0]),
            10 => (near, -near),
            _ => (rng.pick(&[f32::NAN, f32::INFINITY, -0.0]), rng.pick(&[f32::NAN, -1.0, 0.0])),
        };
        ray.between(t_min, t_max)
    })
}
