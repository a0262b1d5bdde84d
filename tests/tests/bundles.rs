//! Traces bundles of rays with a common origin through scenes from all families, and compares the
//! results with a plain loop that calls the reference implementation.

use crate::common;
use intertri::{Mode, Ray, Triangle};
use intertri_lab::rng::Rng;
use intertri_trace::Bvh;

/// Generates rays with the same origin as `ray` and similar directions: scattered, on a raster, or
/// aimed at corners, edges, and points inside triangles. Some of the aimed rays end at their targets.
fn coherent(ray: &Ray, triangles: &[Triangle], rng: &mut Rng, count: usize) -> Vec<Ray> {
    let size = ray.dir.iter().fold(0.0, |m: f32, x| m.max(x.abs()));
    let (spread, kind) = (rng.log(1e-7, 1.0) as f32 * size, rng.below(3));
    let sub = |a: [f32; 3], b: [f32; 3]| [0, 1, 2].map(|k| a[k] - b[k]);
    let ends = rng.one_in(2);
    (0..count)
        .map(|i| {
            let mut t_max = ray.t_max;
            let dir = match kind {
                0 => [0, 1, 2].map(|k| ray.dir[k] + spread * rng.signed() as f32),
                1 => {
                    let [x, y] = [i % 16, i / 16].map(|k| k as f32 * spread / 16.0);
                    [ray.dir[0] + x, ray.dir[1] + y, ray.dir[2]]
                }
                _ => {
                    let [a, b, c] = rng.pick(triangles).0;
                    let middle = [0, 1, 2].map(|k| 0.5 * (a[k] + b[k]));
                    let inside = [0, 1, 2].map(|k| (a[k] + b[k] + c[k]) / 3.0);
                    if ends {
                        t_max = rng.pick(&[1.0, 1.0_f32.next_down(), 1.0 + f32::EPSILON]);
                    }
                    sub(rng.pick(&[a, middle, inside]), ray.origin)
                }
            };
            Ray { dir, t_max, ..*ray }
        })
        .collect()
}

fn scenes(each: usize, seed: u64) {
    common::check_scenes(each, seed, |i, scene, rng| {
        let ray = rng.pick(&scene.rays);
        let count = 2 + rng.below(if i % 4 == 3 { 1498 } else { 298 });
        scene.rays = coherent(&ray, &scene.triangles, rng, count);
    });
}

#[test]
fn every_family_seen_from_one_origin() {
    scenes(35, 7);
}

#[test]
#[ignore = "slow: takes several minutes"]
fn every_family_seen_from_one_origin_at_length() {
    scenes(1000, 8);
}

/// Traces bundles one after another. All triangles have their corners among a few points, and the rays
/// are aimed exactly at these, at middles of edges, and at insides, so many triangles have the same t.
#[test]
fn many_triangles_at_one_point() {
    let rng = &mut Rng::new(11);
    let (mut hits, mut number) = (0, 0);
    for _ in 0..200 {
        let point = |size: usize, rng: &mut Rng| {
            [0; 3].map(|_| rng.below(2 * size + 1) as f32 - size as f32)
        };
        let points: Vec<_> = (0..7).map(|_| point(2, rng)).collect();
        let origins = [point(9, rng), point(9, rng)].map(|[x, y, z]| [x, y, z - 40.0]);
        let triangles: Vec<_> =
            (0..16).map(|_| Triangle([0; 3].map(|_| rng.pick(&points)))).collect();
        let ray_from = |origin: [f32; 3], rng: &mut Rng| {
            let [a, b, c] = rng.pick(&triangles).0;
            let [p, q] = rng.pick(&[[0.0, 0.0], [0.5, 0.0], [0.25, 0.25], [0.5, 0.25]]);
            let at = |k: usize| a[k] + p * (b[k] - a[k]) + q * (c[k] - a[k]);
            Ray::new(origin, [0, 1, 2].map(|k| at(k) - origin[k]))
        };
        let rays: Vec<_> = (0..4096).map(|i| ray_from(origins[i / 1024 % 2], rng)).collect();
        let bvh = Bvh::new(&triangles).unwrap();
        for mode in [Mode::exact(), Mode::once()] {
            let found = bvh.query().mode(mode).on_this_thread().closest_batch(&rays);
            for (ray, hit) in rays.iter().zip(found) {
                let truth = mode.closest(&triangles, ray);
                assert_eq!(hit.is_hit().then_some(hit), truth, "{ray:?} {triangles:?}");
                hits += usize::from(hit.is_hit());
                number += 1;
            }
        }
    }
    assert!(hits > number / 4 && hits < number, "{hits} of {number}");
}
