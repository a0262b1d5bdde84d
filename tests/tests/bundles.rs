//! Traces bundles of rays with a common origin through scenes from all families, and compares the
//! results with a plain loop that calls the reference implementation.

use crate::common;
use intertri::{Ray, Triangle};
use intertri_lab::rng::Rng;

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
