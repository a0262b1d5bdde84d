//! Traces many rays toward one point, such as a light, in scenes from all families, and compares
//! the results with a plain loop that calls the reference implementation.

use crate::common;
use intertri::{Ray, Triangle};
use intertri_lab::rng::Rng;

type V = [f64; 3];

fn to_f64(v: [f32; 3]) -> V {
    v.map(f64::from)
}
fn mix(a: V, b: V, s: f64) -> V {
    [0, 1, 2].map(|k| a[k] + s * (b[k] - a[k]))
}

/// Generates rays that end at `light` or miss it by up to `scatter` times their length. They start
/// behind corners and edges of triangles, just in front of them, or at random positions.
fn to_light(
    light: V,
    triangles: &[Triangle],
    scatter: f64,
    rng: &mut Rng,
    count: usize,
) -> Vec<Ray> {
    let (by_length, ends) = (rng.one_in(3), rng.below(3));
    (0..count)
        .map(|_| {
            let corners = rng.pick(triangles).0.map(to_f64);
            let on_edge = mix(corners[0], corners[1], if rng.one_in(2) { 0.0 } else { rng.unit() });
            let target = if rng.one_in(3) { mix(on_edge, corners[2], rng.unit()) } else { on_edge };
            let beyond = match rng.below(4) {
                0 => 1.0 - rng.log(1e-7, 0.5),
                1 => 1.0 + rng.log(1e-7, 1e-3),
                2 => 1.0,
                _ => 1.0 + rng.log(1e-2, 10.0),
            };
            let origin = mix(light, target, beyond).map(|x| x as f32);
            let way = [0, 1, 2].map(|k| light[k] - f64::from(origin[k]));
            let length = way.iter().fold(0.0, |sum, x| sum + x * x).sqrt();
            let missed = way.map(|x| x + scatter * length * rng.signed());
            let scale = if by_length { length } else { 1.0 };
            let t_max = match ends {
                0 if !by_length => 0.999,
                _ => scale as f32,
            };
            let t_min = if rng.one_in(4) { rng.log(1e-9, 1e-2) * scale } else { 0.0 };
            Ray::new(origin, missed.map(|x| (x / scale) as f32)).between(t_min as f32, t_max)
        })
        .collect()
}

/// Returns the triangles that lie in nearly the same direction from the light as a randomly chosen
/// triangle, so that rays from them form bundles.
fn seen_together(light: V, triangles: &[Triangle], rng: &mut Rng) -> Vec<Triangle> {
    let toward = |triangle: &Triangle| {
        let way = [0, 1, 2].map(|k| f64::from(triangle.0[0][k]) - light[k]);
        let length = way.iter().fold(0.0, |sum, x| sum + x * x).sqrt();
        way.map(|x| x / length)
    };
    let one = rng.pick(triangles);
    let cosine = |triangle: &Triangle| {
        let (a, b) = (toward(triangle), toward(&one));
        a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
    };
    let mut seen: Vec<Triangle> =
        triangles.iter().copied().filter(|triangle| cosine(triangle) > 0.95).collect();
    seen.push(one);
    seen
}

fn scenes(each: usize, seed: u64) {
    common::check_scenes(each, seed, |i, scene, rng| {
        let ray = rng.pick(&scene.rays);
        let size = ray.dir.iter().fold(0.0, |m: f64, x| m.max(f64::from(x.abs())));
        let light = to_f64(ray.origin).map(|x| x + size * rng.signed());
        let scatter = [0.0, 1e-8, 1e-7, 4e-7][i % 4];
        let count = 2 + rng.below(if i % 4 == 3 { 1498 } else { 298 });
        let seen = seen_together(light, &scene.triangles, rng);
        scene.rays = to_light(light, &seen, scatter, rng, count);

        // Replace one ray with an unrelated one, and let another extend beyond the light.
        if rng.one_in(5) {
            scene.rays[rng.below(count)] = ray;
        }
        if rng.one_in(3) {
            scene.rays[rng.below(count)].t_max *= 10.0;
        }
    });
}

#[test]
fn every_family_on_the_way_to_a_light() {
    scenes(35, 9);
}

#[test]
#[ignore = "takes minutes"]
fn every_family_on_the_way_to_a_light_at_length() {
    scenes(1000, 10);
}
