//! Compares f64 hierarchies with a plain loop over all pairs. The `pairs` module compares this
//! loop's arithmetic with rational arithmetic.

use intertri::internal::exact;
use intertri::simd::Level;
use intertri::{Crossing, Hit, Mode, Ray64, Rule, Triangle64};
use intertri_lab::rng::Rng;
use intertri_trace::{Bvh, MeshTriangle};

/// Returns the hits of a ray, sorted by t.
fn hits(triangles: &[Triangle64], ray: &Ray64) -> Vec<Hit> {
    let found = |(i, triangle): (usize, &Triangle64)| {
        exact::hit(Rule::Closed, ray, triangle).then(|| {
            let (t, u, v) = exact::attributes(ray, triangle);
            Hit { t, u, v, triangle: i as u32, geometry: 0 }
        })
    };
    let mut all: Vec<Hit> = triangles.iter().enumerate().filter_map(found).collect();
    all.sort_by(|a, b| {
        let [at, bt] = [a, b].map(|hit| &triangles[hit.triangle as usize]);
        exact::order(ray, at, bt).then(a.triangle.cmp(&b.triangle))
    });
    all
}

/// Checks every query for every ray, one by one and in batches. Returns the number of rays that hit
/// something.
pub(crate) fn check(name: &str, triangles: &[Triangle64], rays: &[Ray64]) -> usize {
    let bvh = Bvh::new(triangles).unwrap();
    let wanted: Vec<Vec<Hit>> = rays.iter().map(|ray| hits(triangles, ray)).collect();
    for level in Level::all() {
        let mode = Mode::exact().at(level);
        let (mut query, mut once) = (bvh.query().at(level), bvh.query().once().at(level));
        let (closest, any) = (query.closest_batch(rays), query.any_batch(rays));
        let triangle = query.closest_triangle_batch(rays);
        let lists = [None, Some(1)].map(|limit| query.crossings_batch(rays, limit).unwrap());
        for (i, (ray, want)) in rays.iter().zip(&wanted).enumerate() {
            let what = || format!("{name} {} ray {i}: {ray:?}", level.name());
            let first = want.first().copied();
            let of = |hit: Hit| MeshTriangle { triangle: hit.triangle, geometry: 0 };
            assert_eq!(closest[i].some(), first, "closest batch, {}", what());
            assert_eq!(bvh.query().at(level).closest(ray), first, "closest, {}", what());
            assert_eq!(triangle[i], first.map_or(MeshTriangle::MISS, of), "{}", what());
            assert_eq!(any[i], first.is_some(), "any batch, {}", what());
            assert_eq!(bvh.query().at(level).any(ray), first.is_some(), "any, {}", what());
            assert_eq!(query.closest(ray), first, "kept query, {}", what());
            assert_eq!(query.closest_triangle(ray), first.map(of), "kept query, {}", what());
            assert_eq!(query.any(ray), first.is_some(), "kept query, {}", what());
            assert_eq!(&query.all(ray), want, "all, {}", what());
            assert_eq!(mode.closest(triangles, ray), first, "closest of a slice, {}", what());
            assert_eq!(mode.any(triangles, ray), first.is_some(), "any of a slice, {}", what());
            assert_eq!(&mode.all(triangles, ray), want, "all of a slice, {}", what());

            // Crossings are the hits under the once rule, which assigns each point of a mesh to one
            // triangle.
            let sided = want.iter().filter_map(|&hit| {
                let side = exact::crossing(ray, &triangles[hit.triangle as usize])?;
                Some(Crossing { hit, leaves: side == exact::Side::Leaves })
            });
            let sided: Vec<Crossing> = sided.collect();
            assert_eq!(query.crossings(ray), sided, "crossings, {}", what());
            assert_eq!(mode.crossings(triangles, ray), sided, "of a slice, {}", what());
            assert_eq!(query.next_crossing(ray), sided.first().copied(), "next, {}", what());
            assert_eq!(lists[0].of(i), sided, "batch, {}", what());
            assert_eq!(lists[1].of(i), &sided[..sided.len().min(1)], "limit, {}", what());
            let hits: Vec<Hit> = sided.iter().map(|crossing| crossing.hit).collect();
            let of_slice = Mode::once().at(level).all(triangles, ray);
            assert_eq!((once.all(ray), of_slice), (hits.clone(), hits), "once, {}", what());
        }
    }
    wanted.iter().filter(|hits| !hits.is_empty()).count()
}

/// Generates triangles around points in a cube, rotated and moved.
pub(crate) fn soup(
    count: usize,
    size: f64,
    scale: f64,
    moved: f64,
    rng: &mut Rng,
) -> Vec<Triangle64> {
    let place = |[x, y, z]: [f64; 3]| {
        // Rotate the points, so that no coordinate has trailing zeros.
        let (c, s) = (0.8, 0.6);
        [c * x - s * y, s * x + c * y, z].map(|x| x * scale + moved)
    };
    let mut triangle = || {
        let at = rng.cube();
        let mut corner = || {
            let d = rng.cube();
            place([0, 1, 2].map(|k| at[k] + size * d[k]))
        };
        Triangle64([corner(), corner(), corner()])
    };
    (0..count).map(|_| triangle()).collect()
}

/// Generates rays toward corners, edges and the insides of triangles, and some in random
/// directions. They start far away, nearby, or on the surface.
pub(crate) fn rays(triangles: &[Triangle64], count: usize, rng: &mut Rng) -> Vec<Ray64> {
    let mix = |a: [f64; 3], b: [f64; 3], s: f64| [0, 1, 2].map(|k| a[k] + s * (b[k] - a[k]));
    (0..count)
        .map(|i| {
            let [a, b, c] = rng.pick(triangles).0;
            let [d, e, f] = rng.pick(triangles).0;
            let on = mix(mix(a, b, rng.unit()), c, rng.unit());
            let target = match i % 5 {
                0 => a,
                1 => mix(a, b, 0.5),
                2 => mix(a, b, rng.unit()),
                _ => on,
            };
            let origin = match i % 7 {
                0 => mix(d, e, rng.unit()),
                1 => d,
                2 => mix(mix(d, e, 0.5), f, 0.25),
                3 => mix(on, d, 1e-9),
                _ => mix(on, d, 3.0 * rng.signed()),
            };
            let dir = [0, 1, 2].map(|k| target[k] - origin[k]);
            let dir = if i % 11 == 0 { rng.direction() } else { dir };
            let ray = Ray64::new(origin, dir);
            match i % 13 {
                0 => ray.between(0.5, 1.0),
                1 => ray.between(1.0, 2.0),
                2 => ray.between(-1.0, 1.0_f64.next_up()),
                3 => ray.between(1.0_f64.next_down(), 1e300),
                _ => ray,
            }
        })
        .collect()
}

#[test]
fn models_moved_and_turned() {
    let mut rng = Rng::new(37);
    for moved in [0.0, 1e3, 1e6, 1e9, 1e12] {
        for size in [0.3, 0.03] {
            let triangles = soup(300, size, 1.0, moved, &mut rng);
            let rays = rays(&triangles, 700, &mut rng);
            let hit = check(&format!("moved by {moved:e}"), &triangles, &rays);
            assert!(hit > 300, "{moved:e}: {hit}");
        }
    }
}

/// Traces parallel rays, which form bundles of copies. In f32, neither their origins nor their
/// direction are exact.
#[test]
fn parallel_rays_moved_and_turned() {
    let mut rng = Rng::new(43);
    for (i, moved) in [0.0, 1.0, 30.0, 1e3, 1e5, 0.0, 10.0, 1e7].into_iter().enumerate() {
        let triangles = soup(150, [0.3, 0.03][i % 2], 1.0, moved, &mut rng);
        for kind in 0..4 {
            let [a, b, _] = rng.pick(&triangles).0;
            let dir = match kind {
                0 => [0, 1, 2].map(|k| b[k] - a[k]),
                1 => [0.0, 0.0, -0.3],
                _ => rng.direction(),
            };
            let mut parallel = |ray: Ray64| {
                // Move each origin along the direction, through the target.
                let target = [0, 1, 2].map(|k| ray.origin[k] + ray.dir[k]);
                let back = [1.0, 0.5, 2.0][rng.below(3)] * if kind == 3 { 1.0 } else { rng.unit() };
                let origin = [0, 1, 2].map(|k| target[k] - back * dir[k]);
                let t_max = if kind % 2 == 0 { f64::INFINITY } else { ray.t_max };
                Ray64 { origin, dir, t_max, ..ray }
            };
            let rays = rays(&triangles, 500, &mut Rng::new(44));
            let rays: Vec<Ray64> = rays.into_iter().map(&mut parallel).collect();
            let hit = check(&format!("moved by {moved:e}, {kind}"), &triangles, &rays);
            assert!(hit > 100, "{moved:e}: {hit}");
        }
    }
}

/// Tests objects of sizes 1e-6 to 1e12 in one scene, scaled until the exponents reach their limits.
#[test]
fn extents_of_every_size() {
    let mut rng = Rng::new(38);
    let extents = |scale: f64, rng: &mut Rng| {
        let mut all = vec![];
        for size in [1e-6, 1e-3, 1.0, 1e6, 1e12] {
            all.extend(soup(30, 0.5, size * scale, 0.0, rng));
        }
        all
    };
    for scale in [1.0, 1e-20, 1e20, 1e-295, 1e-310, 1e295] {
        let triangles = extents(scale, &mut rng);
        let rays = rays(&triangles, 300, &mut rng);
        let hit = check(&format!("extents times {scale:e}"), &triangles, &rays);
        assert!(hit > 100, "{scale:e}: {hit}");
    }
}

/// Tests degenerate triangles, and rays that are not finite, have no direction, or start at extreme
/// coordinates.
#[test]
fn what_is_not_finite_or_nothing() {
    let mut rng = Rng::new(39);
    let mut triangles = soup(60, 0.4, 1.0, 5e5, &mut rng);
    triangles[7].0[1][2] = f64::NAN;
    triangles[8].0[0][0] = f64::INFINITY;
    triangles[9].0 = [triangles[9].0[0]; 3];
    let mut rays = rays(&triangles[10..], 200, &mut rng);
    let numbers = [f64::NAN, f64::INFINITY, -0.0, 5e-324, f64::MAX, -f64::MAX, 1e-310, 1e200];
    for i in 0..400 {
        let mut ray = rays[i % 200];
        let numbers8: &mut [f64; 8] = bytemuck::cast_mut(&mut ray);
        numbers8[i % 8] = numbers[i / 8 % 8];
        if i % 3 == 0 {
            numbers8[i / 3 % 8] = numbers[i / 24 % 8];
        }
        rays.push(ray);
    }
    rays.push(Ray64::new([5e5; 3], [0.0; 3]));
    rays.push(Ray64::new([5e5; 3], [5e-324; 3]));
    rays.push(Ray64::new([5e5; 3], [f64::MAX; 3]));
    assert!(check("odd numbers", &triangles, &rays) > 100);
    assert!(Bvh::<f64>::new(&[]).unwrap().closest(&rays[0]).is_none());
}

/// If t overflows f64, it is infinite, and if it underflows, it is 0. For an unbounded ray, both
/// values are hits.
#[test]
fn t_beyond_f64() {
    let wall = |z: f64| Triangle64([[-1.0, -1.0, z], [3.0, -1.0, z], [-1.0, 3.0, z]]);
    let far = Bvh::new(&[wall(1e10)]).unwrap();
    let ray = Ray64::new([0.0; 3], [0.0, 0.0, 5e-324]);
    let hit = far.closest(&ray).unwrap();
    assert_eq!((hit.t, hit.triangle), (f64::INFINITY, 0));
    assert!(far.any(&ray));
    assert!(!far.any(&ray.between(0.0, f64::MAX)));
    let near = Bvh::new(&[wall(1e-320)]).unwrap();
    let ray = Ray64::new([0.0; 3], [0.0, 0.0, 1e300]);
    assert_eq!(near.closest(&ray).map(|hit| hit.t), Some(0.0));
    assert!(!near.any(&ray.between(5e-324, 1.0)));
}

/// Traces rays along walls. Some walls are tilted, and some rays run toward their wall, by less than
/// their f32 copies can tell, so that these rays hit walls that they seem to be parallel to.
#[test]
fn rays_along_walls_and_tilted_walls() {
    let mut rng = Rng::new(52);
    for least in [1e-60, 1e-310, 5e-324] {
        let steps = [0.0, 0.0, least, -2.0 * least];
        let walls: Vec<Triangle64> = (0..150)
            .map(|i| {
                let at = if i % 3 == 0 {
                    rng.pick(&[0.0, -0.0])
                } else {
                    0.1 * f64::from(rng.within(9))
                };
                let mut corners = [(); 3].map(|()| rng.cube());
                for corner in &mut corners {
                    // Far from 0, the steps vanish, or are larger.
                    let step = if i % 3 == 1 { at.next_up() - at } else { rng.pick(&steps) };
                    corner[i % 5 % 3] = at + if rng.one_in(3) { step } else { 0.0 };
                }
                Triangle64(corners)
            })
            .collect();
        let mut seemingly_parallel = 0;
        let rays: Vec<Ray64> = (0..300)
            .map(|i| {
                let k = i % 3;
                let wall = rng.pick(&walls);
                let (mut origin, mut dir) = (rng.cube(), rng.direction());
                origin[k] = wall.0[i % 2][k] + if i % 4 == 0 { 0.5 * least } else { 0.0 };
                dir[k] = rng.pick(&[0.0, -0.0, least, -least]);
                let ray = Ray64::new(origin, dir);
                seemingly_parallel += hits(&walls, &ray)
                    .iter()
                    .filter(|hit| {
                        let [a, b, c] = walls[hit.triangle as usize].0.map(|corner| corner[k]);
                        (a - b).abs().max((a - c).abs()) < 1e-50 && dir[k].abs() < 1e-50
                    })
                    .count();
                ray
            })
            .collect();
        check(&format!("steps of {least:e}"), &walls, &rays);
        assert!(seemingly_parallel > 10, "{seemingly_parallel}");
    }
}

/// Traces parallel rays along walls and tilted walls, enough of them for bundles. Among some, every
/// third ray is tilted by less than its f32 copy can tell.
#[test]
fn parallel_rays_along_walls_and_tilted_walls() {
    let (mut rng, mut hit) = (Rng::new(53), 0);
    for case in 0..12 {
        let (k, tilt) = (case % 3, [0.0, 1e-60, -1e-60, 5e-324][case / 3]);
        let walls: Vec<Triangle64> = (0..60)
            .map(|i| {
                let at = if i % 2 == 0 { 0.0 } else { 0.1 * f64::from(rng.within(3)) };
                let mut corners = [(); 3].map(|()| rng.cube());
                for corner in &mut corners {
                    corner[i % 3] = at + if rng.one_in(4) { 1e-60 } else { 0.0 };
                }
                Triangle64(corners)
            })
            .collect();
        let mut dir = rng.direction();
        dir[k] = 0.0;
        let rays: Vec<Ray64> = (0..1500)
            .map(|i| {
                let mut dir = dir;
                dir[k] = if i % 3 == 1 { tilt } else { 0.0 };
                // Start outside, and pass through the plane of a wall, or the middle of a tilted one.
                let mut origin = rng.cube().map(|x| 0.9 * x);
                origin[k] = rng.pick(&walls).0[i % 3][k] + if i % 5 == 0 { 5e-61 } else { 0.0 };
                for j in 0..3 {
                    origin[j] -= 2.0 * dir[j];
                }
                Ray64::new(origin, dir)
            })
            .collect();
        let bvh = Bvh::new(&walls).unwrap();
        let wanted: Vec<Option<Hit>> =
            rays.iter().map(|ray| hits(&walls, ray).first().copied()).collect();
        hit += wanted.iter().flatten().count();
        for level in Level::all() {
            let query = bvh.query().at(level);
            let (closest, any) = (query.closest_batch(&rays), query.any_batch(&rays));
            for (i, (ray, want)) in rays.iter().zip(&wanted).enumerate() {
                assert_eq!(closest[i].some(), *want, "{case} {} {ray:?}", level.name());
                assert_eq!(any[i], want.is_some(), "{case} {} {ray:?}", level.name());
            }
        }
    }
    assert!(hit > 2000, "{hit}");
}
