//! Traces bundles of parallel rays through scenes from all families, and compares the results with
//! a plain loop. Also measures how closely errors approach the bounds of their projection.

use crate::common;
use intertri::internal::{Frame, Windows};
use intertri::simd::{Level, Simd, Vec3, WithSimd};
use intertri::{Mode, Ray, Triangle, TriangleBlock};
use intertri_lab::families::FAMILIES;
use intertri_lab::rng::Rng;
use intertri_tests::check_hierarchy;

type V = [f64; 3];

fn to_f64(v: [f32; 3]) -> V {
    v.map(f64::from)
}
fn sub(a: V, b: V) -> V {
    [0, 1, 2].map(|k| a[k] - b[k])
}
fn dot(a: V, b: V) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}
fn cross(a: V, b: V) -> V {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}
fn mix(a: V, b: V, s: f64) -> V {
    [0, 1, 2].map(|k| a[k] + s * (b[k] - a[k]))
}

/// Chooses a direction: that of a ray, along an axis, or along an edge.
fn direction(ray: &Ray, triangles: &[Triangle], rng: &mut Rng) -> [f32; 3] {
    let size = ray.dir.iter().fold(0.0, |m: f32, x| m.max(x.abs()));
    match rng.below(4) {
        0 => {
            let mut dir = [0.0; 3];
            dir[rng.below(3)] = if rng.one_in(2) { size } else { -size };
            dir
        }
        1 => {
            let [a, b, _] = rng.pick(triangles).0;
            [0, 1, 2].map(|k| b[k] - a[k])
        }
        _ => ray.dir,
    }
}

/// Generates rays with one direction: scattered around the origin of `ray`, on a raster, or through
/// corners, edges, and inner points. Some start on a triangle, some of them end there.
fn in_one_direction(ray: &Ray, triangles: &[Triangle], rng: &mut Rng, count: usize) -> Vec<Ray> {
    let dir = direction(ray, triangles, rng);
    let size = dir.iter().fold(0.0, |m: f32, x| m.max(x.abs()));
    let (spread, kind, ends) = (rng.log(1e-7, 10.0) as f32 * size, rng.below(4), rng.below(4));
    let back = [0.0, 1.0, 0.5, rng.log(1e-6, 100.0)][rng.below(4)];
    let first = rng.pick(triangles);
    let mut rays = Vec::new();
    for i in 0..count {
        let triangle = if rng.one_in(2) { first } else { rng.pick(triangles) };
        let [a, b, c] = triangle.0.map(to_f64);
        let origin = match kind {
            0 => [0, 1, 2].map(|k| ray.origin[k] + spread * rng.signed() as f32),
            1 => {
                let [x, y] = [i % 16, i / 16].map(|k| k as f32 * spread / 16.0);
                [ray.origin[0] + x, ray.origin[1] + y, ray.origin[2]]
            }
            _ => {
                let on_edge = mix(a, b, [0.0, 0.5, rng.unit()][rng.below(3)]);
                let target = if rng.one_in(3) { mix(on_edge, c, rng.unit()) } else { on_edge };
                let back = if kind == 3 && rng.one_in(4) { rng.log(1e-6, 10.0) } else { back };
                [0, 1, 2].map(|k| (target[k] - back * f64::from(dir[k])) as f32)
            }
        };
        let t_max = match ends {
            0 => ray.t_max,
            1 => rng.pick(&[1.0, 1.0_f32.next_down(), 1.0 + f32::EPSILON, back as f32]),
            _ => f32::INFINITY,
        };
        let t_min = if rng.one_in(8) { rng.pick(&[1.0, -1.0, 1e-6, back as f32]) } else { 0.0 };
        rays.push(Ray { origin, dir, t_min, t_max });
    }
    rays
}

fn scenes(each: usize, seed: u64) {
    common::check_scenes(each, seed, |i, scene, rng| {
        let ray = rng.pick(&scene.rays);
        // The first 256 rays are traced in packets, and the next in a bundle.
        let count = if i % 4 == 0 { 2 + rng.below(298) } else { 260 + rng.below(900) };
        scene.rays = in_one_direction(&ray, &scene.triangles, rng, count);
        // One ray may have another direction.
        if rng.one_in(10) {
            scene.rays[rng.below(count)].dir = ray.dir;
        }
    });
}

#[test]
fn every_family_in_one_direction() {
    scenes(35, 21);
}

/// Rays through triangles whose coordinates are beyond what the projection can bound: one corner is
/// beyond 2^40, or products of edges overflow.
#[test]
fn triangles_that_are_too_large_are_neither_lost_nor_hit_by_mistake() {
    let beyond = Triangle([[0.0, 0.0, 5.0], [4e12, 0.0, 5.0], [0.0, 4e12, 5.0]]);
    let (big, more) = ((1_u64 << 38) as f32, (1_u64 << 38) as f32 + 65_536.0);
    let at = (1 << 26) as f32;
    let overflows = Triangle([[-at, -at, 5.0], [big, -more, 5.0], [-more, big, 5.0]]);
    for (triangle, from, size) in [(beyond, 1.0, 1.0), (overflows, 0.0, 5.96e-9)] {
        let ray = |i: usize| {
            let [x, y] = [i % 32, i / 32].map(|k| from + size * (k as f32 / 16.0 - 1.0));
            Ray::new([x, y, 0.0], [0.0, 0.0, 1.0])
        };
        let rays: Vec<Ray> = (0..1024).map(ray).collect();
        let mut scene = common::scene(&FAMILIES[0], &mut Rng::new(1), 1, 1);
        (scene.triangles, scene.rays) = (vec![triangle], rays);
        let levels: Vec<Level> = Level::all().collect();
        check_hierarchy(&scene, &levels).unwrap();
    }
}

#[test]
#[ignore = "slow: takes several minutes"]
fn every_family_in_one_direction_at_length() {
    scenes(1000, 22);
}

/// A triangle, a ray near it, and a projection along the ray.
#[derive(Clone, Copy, Debug)]
struct Case {
    triangle: Triangle,
    ray: Ray,
    middle: [f32; 3],
    right: [f32; 3],
    forward: f32,
    /// The extent of the projection across the direction and along it.
    extent: [f32; 2],
}

impl Case {
    /// Chooses a projection that contains the ray, at a distance of up to `size` from its middle.
    fn new(triangle: Triangle, ray: Ray, size: f64, rng: &mut Rng) -> Option<Self> {
        let unit = |v: V| v.map(|x| x / dot(v, v).sqrt());
        let dir = to_f64(ray.dir);
        let right = unit(cross(dir, rng.direction())).map(|x| x as f32);
        let middle = [0, 1, 2].map(|k| (f64::from(ray.origin[k]) + size * rng.signed()) as f32);
        let off = sub(to_f64(ray.origin), to_f64(middle));
        let (long, length) = (dot(off, off).sqrt(), dot(dir, dir).sqrt());
        let extent = [2.5 * long, 1.5 * long / length].map(|x| x as f32);
        let forward = if rng.one_in(2) { 1.0 } else { -1.0 };
        let is_sane = right.iter().chain(&extent).all(|x| x.is_finite())
            && extent[0] > 1e-9
            && extent[0] < 1e9
            && length > 1e-9
            && length < 1e9;
        is_sane.then_some(Self { triangle, ray, middle, right, forward, extent })
    }

    fn frame(&self) -> Frame {
        let [across, deep] = self.extent;
        let dir = (self.ray.dir, self.forward);
        Frame::parallel(self.middle, dir, self.right, 1.0 / across, deep)
    }
}

/// Computes the forms, the error bound of the depth, the unit of the edges, and the point's depth at
/// one SIMD level, and whether the triangle's rectangle and the windows contain the point.
struct Compute<'a>(&'a Case);

impl WithSimd for Compute<'_> {
    type Output = Option<([f32; 4], [f32; 3], bool)>;
    fn run<S: Simd>(self) -> Self::Output {
        let (frame, Case { triangle, ray, .. }) = (self.0.frame(), *self.0);
        let points = frame.origins(Vec3::<f32>::splat(ray.origin));
        if !frame.on_screen(&points) {
            return None;
        }
        let block = TriangleBlock::<8>::new(&[triangle]);
        let outline = Mode::exact().filter().outlines_in::<S>(&block, None, &frame, 1.0).lane(0);
        let (values, err) = outline.at(&points);
        let at = [points.x, points.y];
        let window = Windows::<f32>::new(at, at);
        let reached = outline.near(&window) & outline.within(&window, f32::NEG_INFINITY) != 0;
        Some((values, [err, outline.unit(), points.z], reached))
    }
}

/// Returns how much of the bounds for the edges, for the depth of the plane, and for the depth of the
/// origin a case uses, or `None` if the projection decides nothing.
fn shares(case: &Case, level: Level) -> Option<[f64; 3]> {
    let (values, [err, unit, z], _) = level.run(Compute(case))?;
    if values.iter().any(|x| !x.is_finite()) {
        return None;
    }
    let limits = case.frame().parallel_rays().unwrap();
    let [length, scale, away] = [limits.length, limits.scale, limits.away].map(f64::from);
    let d = to_f64(case.ray.dir).map(|x| f64::from(case.forward) * x);
    let [c1, c2, c3] = case.triangle.0.map(to_f64);
    let (o, m) = (to_f64(case.ray.origin), to_f64(case.middle));
    let (a, h4, h5) = (sub(c1, o), sub(c2, c1), sub(c3, c1));
    let n = cross(h4, h5);
    let (fv, fw, den) = (dot(cross(h5, a), d), dot(cross(a, h4), d), dot(n, d));
    let fu = den - fv - fw;

    // In the frame's axes, a determinant is larger by scale² / |d|.
    let unit = f64::from(unit) * den.signum() * length / (scale * scale);
    let edge = [fu, fv, fw]
        .iter()
        .zip(values)
        .map(|(f, value)| (f64::from(value) - f / unit).abs())
        .fold(0.0, f64::max);
    let begin = dot(sub(o, m), d) / dot(d, d);
    let s = -(begin + dot(n, a) / den);
    let depth = (f64::from(values[3]) - s).abs() / f64::from(err);
    let place = (f64::from(z) - begin).abs() / (6.0 * away / length / f64::from(1 << 24));
    Some([edge, depth, place])
}

/// No family may exceed a bound, and a search must find inputs that use a considerable share of
/// each bound.
#[test]
fn the_bounds_hold_and_are_not_idle() {
    let levels: Vec<Level> = Level::all().collect();
    let mut worst = [0.0_f64; 3];
    for family in FAMILIES {
        let (mut rng, mut most) = (Rng::new(23), [0.0_f64; 3]);
        for i in 0..400 {
            let scene = common::scene(family, &mut rng, 1, 1);
            let (triangle, ray) = (scene.triangles[0], scene.rays[0]);
            let size = ray.origin.iter().fold(1e-3, |m: f64, x| m.max(f64::from(x.abs())));
            let size = size * rng.log(1e-5, 1.0);
            let Some(case) = Case::new(triangle, ray, size, &mut rng) else { continue };
            let Some(used) = shares(&case, levels[i % levels.len()]) else { continue };
            assert!(used.iter().all(|x| *x < 1.0), "{}: {used:?}\n{case:?}", family.name);
            most = [0, 1, 2].map(|k| most[k].max(used[k]));
        }
        println!(
            "{:20} edges {:.3} depth {:.3} place {:.3}",
            family.name, most[0], most[1], most[2]
        );
        worst = [0, 1, 2].map(|k| worst[k].max(most[k]));
    }

    // Climb toward the largest share of each bound, one number at a time.
    for seed in 0..18 {
        let (mut rng, which) = (Rng::new(300 + seed), seed as usize % 3);
        let corner = |rng: &mut Rng| rng.cube().map(|x| x as f32);
        let triangle = Triangle([corner(&mut rng), corner(&mut rng), corner(&mut rng)]);
        let ray = Ray::new(corner(&mut rng), corner(&mut rng));
        let size = rng.log(0.01, 10.0);
        let Some(mut case) = Case::new(triangle, ray, size, &mut rng) else { continue };
        let mut best = 0.0;
        for _ in 0..20_000 {
            let mut next = case;
            let small = rng.log(1e-7, 0.3) as f32;
            let number = match rng.below(18) {
                k @ 0..9 => &mut next.triangle.0[k / 3][k % 3],
                k @ 9..12 => &mut next.ray.dir[k - 9],
                k @ 12..15 => &mut next.ray.origin[k - 12],
                k => &mut next.middle[k - 15],
            };
            *number += small * rng.signed() as f32;
            // The axis must stay perpendicular to the direction.
            let (d, r) = (to_f64(next.ray.dir), to_f64(next.right));
            let along = dot(d, r) / dot(d, d);
            let r = [0, 1, 2].map(|k| r[k] - along * d[k]);
            next.right = r.map(|x| (x / dot(r, r).sqrt()) as f32);
            if let Some(used) = shares(&next, Level::best()) {
                assert!(used.iter().all(|x| *x < 1.0), "{used:?}\n{next:?}");
                if used[which] > best {
                    (case, best) = (next, used[which]);
                }
            }
        }
        worst[which] = worst[which].max(best);
    }
    println!("search: edges {:.3} depth {:.3} place {:.3}", worst[0], worst[1], worst[2]);
    assert!(worst[0] > 0.08 && worst[1] > 0.1 && worst[2] > 0.2, "{worst:?}");
}

/// If a ray passes just inside an edge, the triangle's rectangle and the windows contain its point.
#[test]
fn a_triangle_reaches_the_points_of_its_rays() {
    let (mut rng, mut seen) = (Rng::new(24), 0);
    for i in 0..200_000 {
        let number = |rng: &mut Rng| rng.cube().map(|x| x as f32);
        let triangle = Triangle([number(&mut rng), number(&mut rng), number(&mut rng)]);
        let [c1, c2, c3] = triangle.0.map(to_f64);
        let on_edge = mix(mix(c1, c2, rng.unit()), c3, 1e-6 * rng.unit());
        let (dir, back) = (number(&mut rng), rng.log(1e-3, 30.0));
        let origin = [0, 1, 2].map(|k| (on_edge[k] - back * f64::from(dir[k])) as f32);
        let size = rng.log(1e-3, 1e3);
        let Some(case) = Case::new(triangle, Ray::new(origin, dir), size, &mut rng) else {
            continue;
        };
        // Rounding the origin may move the ray to the other side of the edge.
        if Mode::exact().closest(&[triangle], &case.ray).is_none() {
            continue;
        }
        let level = if i % 2 == 0 { Level::best() } else { Level::PORTABLE };
        if let Some((.., reached)) = level.run(Compute(&case)) {
            seen += 1;
            assert!(reached, "{case:?}");
        }
    }
    assert!(seen > 10_000, "{seen}");
}
