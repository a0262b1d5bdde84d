//! Rays that leave a triangle never hit it, and start where they say.

use crate::common;
use intertri::{Exact, Mode, Ray, Triangle, leave};
use intertri_lab::families::FAMILIES;
use intertri_lab::rng::Rng;

/// Every family, in directions of all kinds, many of them nearly in the triangle's plane.
#[test]
fn no_ray_meets_the_triangle_that_it_leaves() {
    let (mut left, mut moved, mut rng) = (0, 0, Rng::new(21));
    let exact = Exact::default();
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
                    let next = leave(ray, &hit, &triangle, dir);
                    assert!(
                        !exact.any(&[triangle], &next),
                        "{}: {ray:?} {triangle:?}",
                        family.name
                    );
                    moved += u32::from(!near(ray, hit.point(ray), &next, 0.51));
                    // What f64 takes for the normal must be one, nearly.
                    let at = hit.point(ray);
                    if sure_normal(&triangle) && at.iter().all(|x| x.abs() < 1e38) {
                        assert!(
                            near(ray, at, &next, 6.0),
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

/// Whether a ray starts within so many units of a point: of its last place, or of what f64 has lost.
fn near(ray: &Ray, at: [f64; 3], next: &Ray, units: f64) -> bool {
    let largest = |v: [f64; 3]| v.into_iter().fold(0.0, |most: f64, x| most.max(x.abs()));
    let last_place = largest(at) * f64::from(f32::EPSILON) + f64::from(f32::MIN_POSITIVE);
    let way = largest(ray.origin.map(f64::from))
        + largest([0, 1, 2].map(|k| at[k] - f64::from(ray.origin[k])));
    let unit = last_place.max(way / (1_u64 << 50) as f64);
    (0..3).all(|k| (f64::from(next.origin[k]) - at[k]).abs() <= units * unit)
}

/// Whether f64 knows the axis nearest to the normal, and its sign there: beyond the rounding of its products.
fn sure_normal(triangle: &Triangle) -> bool {
    let [a, b, c] = triangle.0.map(|c| c.map(f64::from));
    let most = (0..3).fold(0.0_f64, |most, k| most.max((b[k] - a[k]).abs() * 3.0));
    let most = most * (0..3).fold(0.0_f64, |most, k| most.max((c[k] - a[k]).abs()));
    triangle.normal().iter().any(|n| n.abs() > 1e-12 * most)
}
