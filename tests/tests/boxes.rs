//! Tests how traversal widens boxes: in scenes whose objects differ greatly in size, with distant
//! origins, and with rays along the sides of boxes.
//!
//! If a box is too small by a few ulps, traversal loses hits. Every ray here is therefore aimed at
//! something that its box barely contains: a corner, an edge, a triangle in a face of the box, or a
//! hit at the end of the ray.

use intertri::simd::Level;
use intertri::{Ray, Ray64, Triangle, Triangle64, TriangleOf};
use intertri_lab::rng::Rng;
use intertri_tests::{Scene, as_source, check_hierarchy};

use crate::f64::hierarchy::check as check64;

/// Generates a number of either sign whose magnitude is between two powers of two.
fn sized(rng: &mut Rng, exponents: [i32; 2]) -> f32 {
    let size = rng.log(f64::from(exponents[0]).exp2(), f64::from(exponents[1]).exp2());
    if rng.one_in(2) { size as f32 } else { -size as f32 }
}

/// Generates triangles of one size around a point. A third of them lie in planes perpendicular to
/// an axis.
fn cluster(rng: &mut Rng, count: usize, at: [f32; 3], size: f32) -> Vec<Triangle> {
    let triangle = |_| {
        let mut point = || [0, 1, 2].map(|k| at[k] + size * (rng.unit() as f32 - 0.5));
        let mut corners = [point(), point(), point()];
        if let axis @ 0..3 = rng.below(9) {
            for corner in &mut corners {
                corner[axis] = at[axis];
            }
        }
        Triangle(corners)
    };
    (0..count).map(triangle).collect()
}

/// Picks a point of a triangle: a corner, the midpoint of an edge, or a point inside. Most of these
/// points are barely inside the triangle's box.
fn place(rng: &mut Rng, TriangleOf([a, b, c]): &Triangle) -> [f32; 3] {
    let middle = |p: &[f32; 3], q: &[f32; 3]| [0, 1, 2].map(|k| 0.5 * p[k] + 0.5 * q[k]);
    match rng.below(6) {
        0 => *a,
        1 => *b,
        2 => *c,
        3 => middle(a, b),
        4 => middle(&middle(a, b), c),
        _ => middle(b, c),
    }
}

/// Generates a ray toward a point of a triangle. Its origin is near or far, and its direction can
/// have any length. Some rays are parallel to axes, and some end near the point.
fn toward(rng: &mut Rng, triangle: &Triangle, origins: [i32; 2]) -> Ray {
    let to = place(rng, triangle);
    let mut origin = [(); 3].map(|()| sized(rng, origins));
    // Align the origin with the point along some axes, where the direction is then 0 or nearly 0.
    for axis in 0..3 {
        if rng.one_in(4) {
            origin[axis] = to[axis];
        }
    }
    let times = if rng.one_in(3) { sized(rng, [-90, 40]).abs() } else { 1.0 };
    let mut dir = [0, 1, 2].map(|k| (to[k] - origin[k]) * times);
    if rng.one_in(8) {
        dir[rng.below(3)] *= 1e-30;
    }
    if rng.one_in(50) {
        dir = [0.0, -0.0, 0.0];
    }
    let end = 1.0 / times;
    let t_max = match rng.below(6) {
        0 => end,
        1 => end.next_up(),
        2 => end.next_down(),
        _ => f32::INFINITY,
    };
    Ray::new(origin, dir).between(if rng.one_in(6) { 0.5 * end } else { 0.0 }, t_max)
}

fn checked(triangles: Vec<Triangle>, rays: Vec<Ray>, levels: &[Level], what: &str) -> usize {
    let scene = Scene { triangles, rays, threshold: 0.0 };
    check_hierarchy(&scene, levels).unwrap_or_else(|difference| {
        let small = if scene.triangles.len() < 20 { as_source(&scene) } else { String::new() };
        panic!("{what}: {difference}\n{small}")
    })
}

/// Makes a scene with clusters of very different sizes, and rays toward all of them.
fn scene(rng: &mut Rng, sizes: [i32; 2], origins: [i32; 2]) -> (Vec<Triangle>, Vec<Ray>) {
    let mut triangles = Vec::new();
    for _ in 0..=rng.below(6) {
        let at = if rng.one_in(2) { [0.0; 3] } else { [(); 3].map(|()| sized(rng, sizes)) };
        let (count, size) = (1 + rng.below(60), sized(rng, sizes).abs());
        triangles.extend(cluster(rng, count, at, size));
    }
    // Let some rays share the origin of others, so that they form bundles.
    let mut rays: Vec<Ray> = Vec::new();
    for _ in 0..80 {
        let triangle = rng.pick(&triangles);
        let ray = toward(rng, &triangle, origins);
        rays.push(ray);
        for _ in 0..rng.below(3) {
            let (to, from) = (place(rng, &triangle), ray.origin);
            rays.push(Ray::new(from, [0, 1, 2].map(|k| to[k] - from[k])));
        }
    }
    (triangles, rays)
}

/// Checks random scenes, alternating between the SIMD levels. Returns the number of hits.
fn scenes(seed: u64, count: usize, sizes: [i32; 2], origins: [i32; 2]) -> usize {
    let levels: Vec<Level> = Level::all().collect();
    let (mut rng, mut hits) = (Rng::new(seed), 0);
    for i in 0..count {
        let (triangles, rays) = scene(&mut rng, sizes, origins);
        let level = &levels[i % levels.len()..][..1];
        hits += checked(triangles, rays, level, &format!("{sizes:?} {origins:?}, scene {i}"));
    }
    hits
}

#[test]
fn detail_in_wide_scenes() {
    let hits = scenes(1, 150, [-12, 20], [-10, 20]);
    assert!(hits > 3000, "{hits}");
}

#[test]
fn origins_to_1e30() {
    let hits = scenes(2, 100, [-8, 4], [0, 100]);
    assert!(hits > 500, "{hits}");
}

#[test]
fn sizes_from_one_end_of_f32_to_the_other() {
    let hits = scenes(3, 150, [-140, 120], [-140, 120]);
    assert!(hits > 500, "{hits}");
}

/// Traces many rays in rows from one origin, toward a small mesh next to a large ground triangle
/// and a stray triangle. The rays form bundles whose frusta barely meet the mesh's corners.
#[test]
fn bundles_in_wide_scenes() {
    let levels: Vec<Level> = Level::all().collect();
    let mut rng = Rng::new(4);
    let mut hits = 0;
    for i in 0..30 {
        let far = rng.log(1e2, 1e9) as f32;
        let mut triangles = cluster(&mut rng, 100, [0.0; 3], 1.0);
        triangles.push(Triangle([[-far, -far, -1.0], [far, -far, -1.0], [0.0, far, -1.0]]));
        triangles.push(Triangle([[far, 0.0, 0.0], [far * 1.5, 0.0, 0.0], [far, far, 0.0]]));
        let eye = [sized(&mut rng, [-3, 14]), sized(&mut rng, [-3, 3]), 3.0];
        let at = rng.pick(&triangles);
        let to = place(&mut rng, &at);
        let wide = rng.log(1e-4, 0.3) as f32;
        let ray = |n: usize| {
            let [x, y] = [n % 16, n / 16].map(|k| wide * (k as f32 / 8.0 - 1.0));
            Ray::new(eye, [to[0] + x - eye[0], to[1] + y - eye[1], to[2] - eye[2]])
        };
        let rays = (0..256).map(ray).collect();
        hits += checked(triangles, rays, &levels[i % levels.len()..][..1], &format!("scene {i}"));
    }
    assert!(hits > 1000, "{hits}");
}

/// Tests needles of varying thinness, with rays from a common origin and from random origins. In
/// f64, the normals of the thinnest needles are lost to rounding.
#[test]
fn needles_have_boxes() {
    let levels: Vec<Level> = Level::all().collect();
    let mut rng = Rng::new(5);
    let mut hits = 0;
    for i in 0..40 {
        let needle = |rng: &mut Rng| {
            let at = [(); 3].map(|()| rng.unit() as f32);
            let along = [(); 3].map(|()| rng.unit() as f32 - 0.5);
            let off = [(); 3].map(|()| sized(rng, [-60, -10]));
            let [b, c] = [1.0, 0.5].map(|t| [0, 1, 2].map(|k| at[k] + t * along[k]));
            Triangle([at, b, [0, 1, 2].map(|k| c[k] + off[k])])
        };
        let mut triangles: Vec<Triangle> = (0..40).map(|_| needle(&mut rng)).collect();
        triangles.extend(cluster(&mut rng, 20, [0.5; 3], 1.0));
        let eye = [0.4, 0.6, 4.0];
        let ray = |n: usize, rng: &mut Rng| {
            let triangle = rng.pick(&triangles);
            let to = place(rng, &triangle);
            let from = if n < 64 { eye } else { [(); 3].map(|()| sized(rng, [-2, 4])) };
            Ray::new(from, [0, 1, 2].map(|k| to[k] - from[k]))
        };
        let rays = (0..128).map(|n| ray(n, &mut rng)).collect();
        hits += checked(triangles, rays, &levels[i % levels.len()..][..1], &format!("scene {i}"));
    }
    assert!(hits > 1500, "{hits}");
}

/// Tests wide scenes in f64, including scenes whose small details vanish in f32.
#[test]
fn wide_scenes_in_f64() {
    let mut rng = Rng::new(6);
    let mut hits = 0;
    for i in 0..60 {
        let (triangles, rays) = scene(&mut rng, [-12, 10], [-6, 20]);
        let (scale, to) = (rng.log(1e-9, 1e9), [(); 3].map(|()| rng.log(1e-3, 1e7)));
        let place = |p: [f32; 3]| [0, 1, 2].map(|k| f64::from(p[k]) * scale + to[k]);
        let mut triangles: Vec<Triangle64> =
            triangles.iter().map(|t| TriangleOf(t.0.map(place))).collect();
        if rng.one_in(2) {
            let far = 1e9 * scale;
            triangles.push(TriangleOf([[far, 0.0, 0.0], [far, far, 0.0], [0.0, far, 1.0]]));
        }
        let ray = |ray: &Ray| Ray64 {
            origin: place(ray.origin),
            dir: ray.dir.map(|x| f64::from(x) * scale),
            t_min: f64::from(ray.t_min),
            t_max: f64::from(ray.t_max),
        };
        let rays: Vec<Ray64> = rays.iter().map(ray).collect();
        hits += check64(&format!("scene {i}"), &triangles, &rays);
    }
    assert!(hits > 1500, "{hits}");
}

/// A case found by hand: when the origin was clamped along only one axis, it moved off the ray's
/// line, and the ray missed.
#[test]
fn a_ray_from_beyond_f32_keeps_its_line() {
    let triangle = TriangleOf([[0.0, -1.0, -1.0], [0.0, 1.0, -1.0], [0.0, 0.0, 2.0]]);
    let power = |e: i32| 2.0_f64.powi(e);
    let ray = |e: i32, steep: i32| {
        Ray64::new([power(e), -power(e - steep), 0.1], [-1.0, power(-steep), 0.0])
    };
    let rays: Vec<Ray64> = (90..200).step_by(5).flat_map(|e| [ray(e, 40), ray(e, 65)]).collect();
    assert_eq!(check64("from beyond f32", &[triangle], &rays), rays.len());
}

/// Tests f64 rays that start beyond the range of f32, far along some axes and less far along
/// others.
#[test]
fn origins_beyond_f32() {
    let mut rng = Rng::new(7);
    let mut hits = 0;
    for i in 0..6 {
        let triangles: Vec<Triangle64> = cluster(&mut rng, 20, [0.0; 3], 4.0)
            .iter()
            .map(|t| TriangleOf(t.0.map(|p| p.map(f64::from))))
            .collect();
        // Along some axes, the direction is 0 and the origin is near the centre. Along the others,
        // the line passes exactly through the centre, because the origin is a power of two times
        // the direction.
        let ray = |_| {
            let steep = [(); 3].map(|()| if rng.one_in(3) { 0 } else { rng.below(70) as i32 });
            let mut dir = steep.map(|e| (1.0 + 0.25 * rng.below(4) as f64) * f64::from(-e).exp2());
            let widths = if rng.one_in(2) { 80 } else { 700 };
            let out = f64::from(60 + rng.below(widths) as i32).exp2();
            let mut origin = dir.map(|d| -out * d);
            for axis in 0..3 {
                if rng.one_in(3) {
                    (origin[axis], dir[axis]) = (2.0 * rng.unit() - 1.0, 0.0);
                } else if rng.one_in(2) {
                    (origin[axis], dir[axis]) = (-origin[axis], -dir[axis]);
                }
            }
            let t_max = if rng.one_in(4) { 2.0 * out } else { f64::INFINITY };
            Ray64::new(origin, dir).between(0.0, t_max)
        };
        let rays: Vec<Ray64> = (0..32).map(ray).collect();
        // Duplicate each ray, so that neighbours share an origin and form bundles.
        let rays: Vec<Ray64> = rays.iter().flat_map(|&ray| [ray; 2]).collect();
        hits += check64(&format!("scene {i}"), &triangles, &rays);
    }
    assert!(hits > 100, "{hits}");
}
