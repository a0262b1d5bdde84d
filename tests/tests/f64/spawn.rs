//! Tests that rays spawned on an f64 triangle never hit it.

use intertri::{Hit, Ray64, RayOf, Rule, Triangle64, internal::exact, spawn_ray};
use intertri_lab::rng::Rng;
use intertri_trace::Bvh;

use super::cases::{KINDS, case};

/// Spawns rays from the hits of pairs of every kind, in directions of all kinds, many of which are
/// nearly in the triangle's plane.
#[test]
fn no_ray_meets_the_triangle_that_it_starts_on() {
    let (mut left, mut moved, mut rng) = (0, 0, Rng::new(64));
    for i in 0..60_000 {
        let (ray, triangle) = case(i % KINDS, &mut rng);
        if !exact::hit(Rule::Closed, &ray, &triangle) {
            continue;
        }
        let (t, u, v) = exact::attributes(&ray, &triangle);
        let hit = Hit { t, u, v, triangle: 0, geometry: 0 };
        let [a, b, c] = triangle.0;
        let any = rng.direction();
        let along = |to: [f64; 3]| [0, 1, 2].map(|k| 0.5 * to[k] - 0.5 * a[k]);
        let grazing = [0, 1, 2].map(|k| along(b)[k] + any[k] * 1e-14 * along(c)[k]);
        for dir in [any, grazing, along(c), ray.dir, ray.dir.map(|x| -x)] {
            let next = spawn_ray(&hit, &triangle, dir);
            assert!(!exact::hit(Rule::Closed, &next, &triangle), "{ray:?} {triangle:?} {next:?}");
            moved += u32::from(next.origin != hit.point(&ray));
            left += 1;
        }
    }
    assert!(left > 40_000 && moved > left / 20, "{left}, {moved} moved");
}

/// Rays spawned on a wall at UTM coordinates must start within nanometres of the wall and hit an
/// obstacle one micrometre in front of it.
#[test]
fn it_leaves_a_wall_by_nanometres() {
    let (x, y) = (148_376.213, 528_980.447);
    let wall = Triangle64([[x, y, 0.0], [x + 3.1, y + 4.2, 0.0], [x, y, 3.0]]);
    let normal = [0.804, -0.594, 0.0];
    let near = Triangle64(wall.0.map(|c| [0, 1, 2].map(|k| c[k] + 1e-6 * normal[k])));
    let bvh = Bvh::new(&[near]).unwrap();
    let mut rng = Rng::new(65);
    for _ in 0..2000 {
        let (p, q) = (0.2 + 0.5 * rng.unit(), 0.1 + 0.1 * rng.unit());
        let on = [x + 3.1 * p, y + 4.2 * p, 3.0 * q];
        let from = [0, 1, 2].map(|k| on[k] + 7.0 * normal[k]);
        let ray = Ray64::new(from, [0, 1, 2].map(|k| on[k] - from[k]));
        let hit = Bvh::new(&[wall]).unwrap().closest(&ray).unwrap();
        let next: RayOf<f64> = spawn_ray(&hit, &wall, normal);
        let off = [0, 1, 2].map(|k| (next.origin[k] - hit.point(&ray)[k]).abs());
        assert!(off.iter().all(|&off| off < 4e-9), "{off:?}");
        assert!(!exact::hit(Rule::Closed, &next, &wall) && bvh.any(&next), "{next:?}");
    }
}
