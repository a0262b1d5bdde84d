//! Tests that batches of rays in typical orders return the same results as tracing each ray alone,
//! bit for bit.

use std::sync::OnceLock;

use intertri::internal::exact::attributes32;
use intertri::{Crossings, Hit, Hit32, Mode, Ray, Ray64, RayOf, Triangle, TriangleOf};
use intertri_trace::{Bvh, BvhScalar, MeshTriangle};

/// Returns a pseudo-random number in -1..1, computed from two indices.
fn number(i: usize, k: usize) -> f32 {
    let x = (i as u64 + 1).wrapping_mul(0x9e37_79b9_7f4a_7c15).rotate_left(k as u32 * 7 + 11);
    (x.wrapping_mul(0xbf58_476d_1ce4_e5b9) >> 40) as f32 / 8_388_608.0 - 1.0
}

/// Returns a scene of two meshes, one behind the other. Each mesh is a cloud of triangles.
fn scene() -> &'static Bvh {
    static SCENE: OnceLock<Bvh> = OnceLock::new();
    SCENE.get_or_init(|| {
        let cloud = |first: usize, z: f32| -> Vec<Triangle> {
            let triangle = |i: usize| {
                let at = [number(i, 0), number(i, 1), 0.5 * number(i, 2) + z];
                let corner = |k: usize| [0, 1, 2].map(|axis| at[axis] + 0.2 * number(i, k + axis));
                Triangle([corner(3), corner(6), corner(4)])
            };
            (first..first + 600).map(triangle).collect()
        };
        Bvh::from_meshes(&[&cloud(0, 0.0), &cloud(1000, 1.0)]).unwrap()
    })
}

/// The width of the widest image, in pixels.
const WIDEST: usize = 1100;
/// The height of the tallest image, in pixels.
const HIGHEST: usize = 41;

/// Returns the ray from a camera through a pixel, offset from the pixel's centre by up to `jitter`
/// pixels.
fn pixel(camera: usize, x: usize, y: usize, jitter: f32) -> Ray {
    let off = |k: usize| jitter * number(y * WIDEST + x, 20 + k) / 600.0;
    let [u, v] = [x as f32 / 600.0 - 0.9 + off(0), y as f32 / 25.0 - 0.8 + off(1)];
    Ray::new([0.1 * camera as f32, 0.05, -2.5], [u, v, 2.0])
}

/// Returns the rays of an image, row by row.
fn rows(camera: usize, width: usize, height: usize, jitter: f32) -> Vec<Ray> {
    (0..width * height).map(|i| pixel(camera, i % width, i / width, jitter)).collect()
}

/// Returns the expected closest hit in f32. In exact modes, its t, u, and v are the exact values,
/// rounded once to f32; in other modes, they are those of the f64 hit, rounded to f32.
fn in_f32<S: BvhScalar>(bvh: &Bvh<S>, mode: Mode, ray: &RayOf<S>, hit: Option<Hit>) -> Hit32 {
    let Some(hit) = hit else { return Hit32::MISS };
    match bvh.triangle(&hit) {
        Some(triangle) if mode.rule().is_some() => {
            let [t, u, v] = attributes32(ray, &triangle);
            Hit32 { t, u, v, ..hit.into() }
        }
        _ => hit.into(),
    }
}

/// Compares every batch query with queries for single rays.
fn check(name: &str, rays: &[Ray]) {
    let bvh = scene();
    for mode in [Mode::certified(), Mode::exact(), Mode::once()] {
        let mut alone = bvh.query().mode(mode);
        let query = bvh.query().mode(mode);
        let (hits, any) = (query.closest_batch(rays), query.any_batch(rays));
        let (triangles, counts) =
            (query.closest_triangle_batch(rays), query.count_crossings_batch(rays));
        let (all, few) =
            (query.all_batch(rays, None).unwrap(), query.all_batch(rays, Some(2)).unwrap());
        let crossings = query.crossings_batch(rays, None).unwrap();
        let mut hits32 = vec![Hit32::MISS; rays.len()];
        query.closest_batch_into(rays, &mut hits32);
        assert_eq!([all.len(), few.len(), crossings.len()], [rays.len(); 3], "{name}");
        for (i, ray) in rays.iter().enumerate() {
            let closest = alone.closest(ray);
            assert_eq!(hits[i].some(), closest, "{name}, ray {i}: the closest hit, {mode:?}");
            let expected = in_f32(bvh, mode, ray, closest);
            assert_eq!(hits32[i], expected, "{name}, ray {i}: the closest hit in f32, {mode:?}");
            let alone32 = alone.closest32(ray).unwrap_or(Hit32::MISS);
            assert_eq!(alone32, expected, "{name}, ray {i}: one ray in f32, {mode:?}");
            let triangle =
                closest.map_or(MeshTriangle::MISS, |Hit { triangle, geometry, .. }| MeshTriangle {
                    triangle,
                    geometry,
                });
            assert_eq!(triangles[i], triangle, "{name}, ray {i}: the closest triangle, {mode:?}");
            assert_eq!(any[i], closest.is_some(), "{name}, ray {i}: any hit, {mode:?}");
            let hits = alone.all(ray);
            assert_eq!(all.of(i), hits, "{name}, ray {i}: every hit, {mode:?}");
            assert_eq!(
                few.of(i),
                &hits[..hits.len().min(2)],
                "{name}, ray {i}: two hits, {mode:?}"
            );
            let crossed = alone.crossings(ray);
            assert_eq!(crossings.of(i), crossed, "{name}, ray {i}: crossings");
            let mut count = Crossings::default();
            for crossing in &crossed {
                count.add(crossing.leaves);
            }
            assert_eq!(counts[i], count, "{name}, ray {i}: the number of crossings");
        }
    }
    let wide = |ray: &Ray| {
        let [t_min, t_max] = [ray.t_min, ray.t_max].map(f64::from);
        Ray64::new(ray.origin.map(f64::from), ray.dir.map(|x| f64::from(x) + 1e-10))
            .between(t_min, t_max)
    };
    let rays: Vec<Ray64> = rays.iter().map(wide).collect();
    let (bvh, hits) = (scene64(), scene64().closest_batch(&rays));
    let mut hits32 = vec![Hit32::MISS; rays.len()];
    bvh.query().closest_batch_into(&rays, &mut hits32);
    for (i, ray) in rays.iter().enumerate() {
        let closest = bvh.closest(ray);
        assert_eq!(hits[i].some(), closest, "{name}, ray {i} in f64");
        let expected = in_f32(bvh, Mode::exact(), ray, closest);
        assert_eq!(hits32[i], expected, "{name}, ray {i} in f64, the hit in f32");
        let alone32 = bvh.query().closest32(ray).unwrap_or(Hit32::MISS);
        assert_eq!(alone32, expected, "{name}, ray {i} in f64, alone, the hit in f32");
    }
}

/// Returns the scene in f64, with coordinates that f32 cannot represent exactly.
fn scene64() -> &'static Bvh<f64> {
    static SCENE: OnceLock<Bvh<f64>> = OnceLock::new();
    SCENE.get_or_init(|| {
        let wide = |triangle: &Triangle| {
            TriangleOf(triangle.0.map(|corner| corner.map(|x| f64::from(x) + 1e-9)))
        };
        let triangles: Vec<_> = scene().to_triangles().iter().map(wide).collect();
        Bvh::new(&triangles).unwrap()
    })
}

#[test]
fn rows_of_every_width_get_what_each_ray_gets_alone() {
    let whole = rows(0, WIDEST, HIGHEST, 0.0);
    let bvh = scene();
    let alone: Vec<Hit> = whole.iter().map(|ray| bvh.closest(ray).unwrap_or(Hit::MISS)).collect();
    assert!(alone.iter().filter(|hit| hit.is_hit()).count() > alone.len() / 8);
    for width in 1..=WIDEST {
        // The last row is incomplete.
        let height = 8 + width % (HIGHEST - 8);
        let count = width * height + width / 3;
        let at = |i: usize| i / width * WIDEST + i % width;
        let rays: Vec<Ray> = (0..count).map(|i| whole[at(i)]).collect();
        let (hits, any) = (bvh.closest_batch(&rays), bvh.any_batch(&rays));
        for i in 0..count {
            assert_eq!(hits[i], alone[at(i)], "ray {i}, rows of {width} pixels");
            assert_eq!(any[i], alone[at(i)].is_hit(), "ray {i}, rows of {width} pixels");
        }
    }
}

#[test]
fn every_verb_answers_rows_as_rays() {
    for (width, height) in [(32, 9), (33, 31), (97, 40), (128, 33), (131, 17), (509, 8)] {
        check(&format!("{width} by {height}"), &rows(0, width, height, 0.0));
    }
}

#[test]
fn jittered_rows_get_what_each_ray_gets_alone() {
    check("jittered", &rows(1, 150, 35, 0.5));
}

#[test]
fn several_cameras_in_a_batch_get_what_each_ray_gets_alone() {
    let cameras = [(0, 70, 21), (1, 70, 13), (2, 133, 9), (3, 7, 5), (4, 40, 40)];
    let all = cameras.map(|(camera, width, height)| rows(camera, width, height, 0.0));
    check("cameras", &all.concat());
}

#[test]
fn rows_that_end_early_get_what_each_ray_gets_alone() {
    // The end of row 12 is missing, and row 20 has a gap.
    let mut rays = rows(0, 129, 36, 0.0);
    rays.drain(20 * 129 + 40..20 * 129 + 60);
    rays.drain(12 * 129 + 100..13 * 129);
    check("cut", &rays);
    check("cut at the start", &rays[57..]);
}

#[test]
fn rays_of_nan_and_others_among_rows_get_what_each_ray_gets_alone() {
    let mut rays = rows(0, 140, 35, 0.0);
    for (i, x) in [f32::NAN, f32::INFINITY, 0.0, f32::MAX].into_iter().enumerate() {
        rays[1500 + 11 * i].dir = [x; 3];
        rays[2500 + 141 * i].origin[i % 3] = x;
        rays[3500 + 7 * i].t_max = x;
        rays[139 + 140 * i].dir[0] = x;
    }
    check("spoiled", &rays);
}

#[test]
fn columns_and_tiles_get_what_each_ray_gets_alone() {
    let columns: Vec<Ray> = (0..64 * 40).map(|i| pixel(0, i / 40, i % 40, 0.0)).collect();
    check("columns", &columns);
    let bits = |i: usize| (0..5).fold(0, |sum, k| sum | (i >> (2 * k) & 1) << k);
    let tiles: Vec<Ray> =
        (0..5000).map(|i| pixel(0, bits(i) + i / 1024 * 32, bits(i >> 1), 0.0)).collect();
    check("tiles", &tiles);
}

/// A batch is split into chunks, and each chunk must use the skip lists of its own rays.
#[test]
fn each_ray_of_a_large_batch_skips_its_own_triangles() {
    let (bvh, mut passed) = (scene(), 0);
    let rays: Vec<Ray> = (0..20_000).map(|i| pixel(i % 7, i % WIDEST, i / WIDEST, 1.0)).collect();
    let first = bvh.closest_batch(&rays);
    let lists: Vec<&[Hit]> = first
        .iter()
        .map(|hit| if hit.is_hit() { std::slice::from_ref(hit) } else { &[] })
        .collect();
    let query = bvh.query().skip(&lists);
    let (next, all) = (query.closest_batch(&rays), query.all_batch(&rays, None).unwrap());
    for (i, ray) in rays.iter().enumerate() {
        let mut alone = bvh.query().skip(&lists[i..=i]);
        let closest = alone.closest(ray);
        assert_eq!(next[i].some(), closest, "ray {i}");
        assert_eq!(all.of(i), alone.all(ray), "ray {i}");
        passed += usize::from(!lists[i].is_empty() && closest.is_some());
    }
    assert!(passed > 1000, "{passed}");
}

/// Shuffles a list in a way that is the same on every run.
fn shuffled<T>(mut all: Vec<T>) -> Vec<T> {
    for i in (1..all.len()).rev() {
        let share = 0.5 + 0.5 * number(i, 7);
        all.swap(i, ((share * (i + 1) as f32) as usize).min(i));
    }
    all
}

/// Returns a ray from an orthographic camera, offset from its pixel's centre by up to `jitter`
/// pixels.
fn parallel(dir: [f32; 3], x: usize, y: usize, jitter: f32) -> Ray {
    let off = |k: usize| jitter * number(y * WIDEST + x, 20 + k) / 200.0;
    let [u, v] = [x as f32 / 200.0 - 1.0 + off(0), y as f32 / 25.0 - 0.8 + off(1)];
    // All origins are in a plane of constant z in front of the scene.
    Ray::new([u - 2.5 * dir[0], v - 2.5 * dir[1], -2.5 * dir[2]], dir)
}

fn parallel_rows(dir: [f32; 3], width: usize, height: usize, jitter: f32) -> Vec<Ray> {
    (0..width * height).map(|i| parallel(dir, i % width, i / width, jitter)).collect()
}

#[test]
fn rows_of_parallel_rays_get_what_each_ray_gets_alone() {
    for dir in [[0.0, 0.0, 1.0], [0.25, -0.1, 0.9], [0.3, 0.2, -2.0], [1e-9, -0.7, 0.7]] {
        for (width, height, jitter) in [(32, 9, 0.0), (131, 17, 0.0), (400, 41, 0.0), (97, 40, 0.5)]
        {
            let rays = parallel_rows(dir, width, height, jitter);
            check(&format!("{dir:?}, {width} by {height}"), &rays);
        }
    }
}

#[test]
fn parallel_rays_with_ends_and_nan_get_what_each_ray_gets_alone() {
    let mut rays = parallel_rows([0.25, -0.1, 0.9], 400, 41, 0.0);
    for (i, ray) in rays.iter_mut().enumerate().skip(2000) {
        let near = 2.0 + number(i, 40);
        *ray = ray.between(near, near + 0.5 + 0.5 * number(i, 41));
    }
    for (i, x) in [f32::NAN, f32::INFINITY, 0.0, -1.0, f32::MAX].into_iter().enumerate() {
        rays[5000 + 11 * i].dir = [x; 3];
        rays[6000 + 141 * i].origin[i % 3] = x;
        rays[7000 + 7 * i].t_max = x;
        rays[8000 + 7 * i].t_min = x;
        rays[399 + 400 * i].dir[0] = x;
    }
    check("parallel, spoiled", &rays);
}

#[test]
fn parallel_rays_from_a_surface_and_shuffled_get_what_each_ray_gets_alone() {
    let rays = shuffled(parallel_rows([0.25, -0.1, 0.9], 500, 41, 0.2));
    check("parallel, shuffled", &rays);
    // Trace rays toward the sun from the points that camera rays hit.
    let bvh = scene();
    let seen = rows(0, 700, 41, 0.0);
    let toward = |ray: &Ray| {
        let hit = bvh.closest(ray)?;
        Some(
            Ray::new(hit.point(ray).map(|x| x as f32), [0.3, 0.9, -0.4])
                .between(1e-4, f32::INFINITY),
        )
    };
    let rays: Vec<Ray> = seen.iter().filter_map(toward).collect();
    assert!(rays.len() > 2000);
    check("toward the sun", &rays);
    check("toward the sun, shuffled", &shuffled([&rays[..]; 8].concat()));
}

/// Tests shadow rays toward a light. The rays start at the hits of an image's camera rays, row by
/// row, and are traced in bundles (reversed, so that they start at the light) or in packets.
#[test]
fn rays_toward_a_light_get_what_each_ray_gets_alone() {
    let bvh = scene();
    let light = [0.3, 4.0, -1.0];
    let toward = |ray: &Ray| {
        let point = bvh.closest(ray)?.point(ray).map(|x| x as f32);
        let dir = [0, 1, 2].map(|k| light[k] - point[k]);
        Some(Ray::new(point, dir).between(1e-4, 1.0))
    };
    let rays: Vec<Ray> = rows(0, 700, 61, 0.0).iter().filter_map(toward).collect();
    assert!(rays.len() > 8 * 1024, "{}", rays.len());
    check("toward a light", &rays);
    let few: Vec<Ray> = rays.iter().copied().step_by(37).collect();
    check("toward a light, few", &[&few[..], &rays[..], &shuffled(few.clone())].concat());
}

/// Tests rays from and toward a light, whose other ends are what a camera sees of a wavy sheet, row
/// by row and in random order, with a few odd rays among them. They are sorted before they are
/// traced, which takes many rays on one thread.
#[test]
fn rays_of_one_end_are_sorted_and_get_what_each_ray_gets_alone() {
    let height = |x: usize, y: usize| 0.2 * (0.7 * x as f32).sin() * (0.5 * y as f32).cos();
    let corner = |x: usize, y: usize| [x as f32 * 0.1, height(x, y), y as f32 * 0.1];
    let squares = (0..40 * 40).map(|i| (i % 40, i / 40));
    let triangles: Vec<Triangle> = squares
        .flat_map(|(x, y)| {
            let [a, b, c, d] =
                [(x, y), (x + 1, y), (x, y + 1), (x + 1, y + 1)].map(|(x, y)| corner(x, y));
            [Triangle([a, b, c]), Triangle([d, c, b])]
        })
        .collect();
    let bvh = Bvh::new(&triangles).unwrap();
    let light = [1.1, 3.0, -0.7];
    let seen = |i: usize| {
        let [x, y] = [i % 230, i / 230].map(|k| 0.1 + k as f32 / 62.0);
        let from = Ray::new([x, 4.0, y], [0.0, -1.0, 0.0]);
        Some(bvh.closest(&from)?.point(&from).map(|x| x as f32))
    };
    let points: Vec<[f32; 3]> = (0..230 * 230).filter_map(seen).collect();
    assert!(points.len() > 40_000, "{}", points.len());
    let way = |point: &[f32; 3]| [0, 1, 2].map(|k| point[k] - light[k]);
    let from = |point: &[f32; 3]| Ray::new(light, way(point)).between(0.0, 1.5);
    let toward = |point: &[f32; 3]| Ray::new(*point, way(point).map(|d| -d)).between(1e-4, 1.0);
    // The sun is low, so that some points are in shadow.
    let sun = |point: &[f32; 3]| Ray::new(*point, [1.0, 0.08, 0.3]).between(1e-4, f32::INFINITY);

    let spoiled = |mut rays: Vec<Ray>| {
        for (i, x) in [f32::NAN, f32::INFINITY, 0.0, f32::MAX, 1e-40].into_iter().enumerate() {
            // These are not among the rays that are examined before sorting.
            rays[3000 + 7 * i].dir = [x; 3];
            rays[3100 + 7 * i].origin[i % 3] = x;
            rays[3200 + 7 * i].t_max = x;
        }
        rays
    };
    let rows: [Vec<Ray>; 3] = [
        points.iter().map(from).collect(),
        points.iter().map(toward).collect(),
        points.iter().map(sun).collect(),
    ];
    for rays in rows.map(spoiled) {
        for rays in [rays.clone(), shuffled(rays)] {
            let mut alone = bvh.query();
            let query = bvh.query().on_this_thread();
            let (hits, any) = (query.closest_batch(&rays), query.any_batch(&rays));
            let mut met = [0; 2];
            for (i, ray) in rays.iter().enumerate() {
                assert_eq!(hits[i].some(), alone.closest(ray), "ray {i}");
                assert_eq!(any[i], alone.any(ray), "ray {i}");
                met[usize::from(any[i])] += 1;
            }
            assert!(met[1] > 1000, "{met:?}");
        }
    }
}

/// Simulates a scanner on a vehicle: columns of 64 rays from a moving origin.
#[test]
fn rays_of_a_moving_origin_get_what_each_ray_gets_alone() {
    for moved in [1e-3, 0.02, 0.3] {
        let ray = |i: usize| {
            let (beam, turn) = ((i % 64) as f32 / 64.0, (i / 64) as f32 / 200.0);
            let (sin, cos) = (6.3 * turn).sin_cos();
            let dir = [cos, 0.8 * beam - 0.5, sin];
            let near = 0.3 * number(i, 3).abs();
            Ray::new([moved * turn, 0.1, moved * number(i, 4)], dir).between(near, near + 4.0)
        };
        let rays: Vec<Ray> = (0..64 * 200).map(ray).collect();
        check(&format!("a scanner, {moved}"), &rays);
    }
}
