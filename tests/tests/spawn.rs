//! Tests that rays spawned on a triangle never hit it and start where the documentation says they
//! do.

use crate::common;
use intertri::{Hit, Mode, Ray, Triangle, spawn_ray, spawn_ray_to};
use intertri_lab::families::FAMILIES;
use intertri_lab::rng::Rng;

/// Spawns rays from hits in scenes from every family, with directions of all kinds, many of which
/// are nearly in the triangle's plane.
#[test]
fn no_ray_meets_the_triangle_that_it_starts_on() {
    let (mut left, mut moved, mut rng) = (0, 0, Rng::new(21));
    let exact = Mode::exact();
    for family in FAMILIES {
        for _ in 0..20 {
            let scene = common::scene(family, &mut rng, 20, 40);
            for ray in &scene.rays {
                let Some(hit) = exact.closest(&scene.triangles, ray) else { continue };
                let triangle = scene.triangles[hit.triangle as usize];
                let [a, b, c] = triangle.0;
                let along = |from: [f32; 3], to: [f32; 3]| [0, 1, 2].map(|k| to[k] - from[k]);
                let any = rng.direction().map(|x| x as f32);
                let grazing = [0, 1, 2].map(|k| along(a, b)[k] + any[k] * 1e-6 * along(a, c)[k]);
                for dir in [any, grazing, along(a, c), ray.dir, ray.dir.map(|x| -x)] {
                    let next = spawn_ray(&hit, &triangle, dir);
                    assert!(
                        !exact.any(&[triangle], &next),
                        "{}: {ray:?} {triangle:?}",
                        family.name
                    );
                    let at = point(&hit, &triangle);
                    moved += u32::from(!near(&triangle, at, &next, 0.51));
                    // This limit only applies if the f64 normal is nearly correct.
                    let is_small = at.iter().chain(&dir.map(f64::from)).all(|x| x.abs() < 1e38);
                    if sure_normal(&triangle) && is_small {
                        assert!(
                            near(&triangle, at, &next, 6.0),
                            "{}: {ray:?} {next:?} {at:?}",
                            family.name
                        );
                    }
                    left += 1;
                }
            }
        }
    }
    assert!(left > 50_000 && moved > left / 20, "{left}, {moved} moved");
}

/// Returns the point of a triangle that a hit's weights describe.
fn point(hit: &Hit, triangle: &Triangle) -> [f64; 3] {
    let weights = [1.0 - hit.u - hit.v, hit.u, hit.v];
    [0, 1, 2].map(|k| (0..3).map(|i| weights[i] * f64::from(triangle.0[i][k])).sum())
}

/// Returns whether a ray starts within `units` units of a point. A unit is an f32 ulp of the point,
/// or the f64 rounding error of the triangle's coordinates if that is larger.
fn near(triangle: &Triangle, at: [f64; 3], next: &Ray, units: f64) -> bool {
    let largest = |v: &[f64]| v.iter().fold(0.0, |most: f64, x| most.max(x.abs()));
    let last_place = largest(&at) * f64::from(f32::EPSILON) + f64::from(f32::MIN_POSITIVE);
    let corners = triangle.0.as_flattened().iter().map(|x| f64::from(*x)).collect::<Vec<_>>();
    let unit = last_place.max(largest(&corners) / (1_u64 << 49) as f64);
    (0..3).all(|k| (f64::from(next.origin[k]) - at[k]).abs() <= units * unit)
}

/// Returns whether the f64 normal is so long that rounding cannot change its dominant axis or its
/// sign.
fn sure_normal(triangle: &Triangle) -> bool {
    let [a, b, c] = triangle.0.map(|c| c.map(f64::from));
    let most = (0..3).fold(0.0_f64, |most, k| most.max((b[k] - a[k]).abs() * 3.0));
    let most = most * (0..3).fold(0.0_f64, |most, k| most.max((c[k] - a[k]).abs()));
    triangle.normal().iter().any(|n| n.abs() > 1e-12 * most)
}

/// If there is no valid starting point, the ray must not hit anything, even if you change its
/// interval later.
#[test]
fn a_ray_without_a_start_stays_empty() {
    // The coordinates are a few ulps below the largest f32, so the midpoint of an edge rounds to a
    // point behind the triangle, and a step outward overflows to infinity.
    let corner = |v: [u32; 3]| v.map(|below| f32::from_bits(f32::MAX.to_bits() - below));
    let triangle = Triangle([corner([0, 0, 1]), corner([0, 1, 0]), corner([2, 0, 0])]);
    let hit = Hit { t: 1.0, u: 0.0, v: 0.5, triangle: 0, geometry: 0 };
    let start = point(&hit, &triangle).map(|x| x as f32);
    let (exact, dir) = (Mode::exact(), [1.0, -0.1, 1.0]);
    assert!(exact.any(&[triangle], &Ray::new(start, dir)));
    let aim = [0, 1, 2].map(|k| f32::from_bits(start[k].to_bits() + [1, 0, 1][k]));
    let none = spawn_ray(&Hit::MISS, &triangle, dir);
    for next in [spawn_ray(&hit, &triangle, dir), spawn_ray_to(&hit, &triangle, aim), none] {
        assert!(next.origin[0].is_nan());
        for (t_min, t_max) in [(0.0, f32::INFINITY), (-9.0, 9.0)] {
            assert!(!exact.any(&[triangle], &next.between(t_min, t_max)), "{next:?}");
        }
    }
    // A step inward is finite.
    assert!(!spawn_ray(&hit, &triangle, [-1.0, 0.1, -1.0]).origin[0].is_nan());
}

/// A ray spawned toward a target must end at the target and must not hit the triangle on which it
/// starts.
#[test]
fn a_ray_to_a_target_ends_there() {
    let (exact, mut rng) = (Mode::exact(), Rng::new(23));
    for _ in 0..5000 {
        let mut corner = || rng.direction().map(|x| x as f32);
        let (triangle, target) = (Triangle([corner(), corner(), corner()]), corner());
        let (u, v) = (0.5 * rng.unit(), 0.5 * rng.unit());
        let hit = Hit { t: 1.0, u, v, triangle: 0, geometry: 0 };
        let ray = spawn_ray_to(&hit, &triangle, target);
        assert!(!exact.any(&[triangle], &ray) && (ray.t_min, ray.t_max) == (0.0, 1.0));
        let end = [0, 1, 2].map(|k| ray.origin[k] + ray.dir[k]);
        assert!((0..3).all(|k| (end[k] - target[k]).abs() < 1e-6), "{end:?} {target:?}");
    }
}
