//! Tests that a hierarchy over grid triangles returns the same results as a plain loop over all
//! triangles.

use intertri::fixed::{Bits, Fixed, Grid, Ray as GridRay, Triangle, blocks};
use intertri::simd::Level;
use intertri::{Crossing, Crossings, Hit, Ray};

use intertri_tests::grid_reference::{self, crossing, crossings};

use super::{GridBvh, Numbers, add, solids, sub};

/// Generates a sphere, loose triangles, slivers and triangles perpendicular to an axis, some of
/// them duplicated, with coordinates in `-1..=1`.
pub(crate) fn scene(n: &mut Numbers) -> Vec<[[f32; 3]; 3]> {
    let mut number = || (n.next() >> 40) as f32 / 8_388_608.0 - 1.0;
    let mut scene: Vec<[[f32; 3]; 3]> =
        solids::icosphere(2).into_iter().map(|t| t.map(|c| c.map(|x| x * 0.75))).collect();
    for i in 0..300 {
        let at = [number(), number(), number()];
        // Sizes range from a large part of the scene to a hundred-thousandth of it.
        let size = [0.4, 0.02, 1e-5][i % 3];
        let mut corners = [(); 3].map(|()| at.map(|x| (x + size * number()).clamp(-1.0, 1.0)));
        if i % 5 == 0 {
            corners[2] = [0, 1, 2].map(|k| 0.5 * corners[0][k] + 0.5 * corners[1][k]);
        }
        if i % 7 == 0 {
            corners = corners.map(|c| [at[0], c[1], c[2]]);
        }
        scene.push(corners);
        if i % 11 == 0 {
            scene.push([corners[1], corners[2], corners[0]]);
        }
    }
    scene
}

/// Returns the crossings of a ray according to the scalar reference.
fn expected(ray: &GridRay, triangles: &[Triangle]) -> Vec<Crossing> {
    let crossing = |(crossing, index): (grid_reference::Crossing, u32)| Crossing {
        hit: crossing.to_hit(ray, index),
        leaves: crossing.leaves,
    };
    crossings(ray, triangles).into_iter().map(crossing).collect()
}

#[test]
fn the_hierarchy_answers_as_the_queries_over_all_triangles() {
    let mut n = Numbers(11);
    let scene = scene(&mut n);
    let levels: Vec<Fixed> = Level::all().map(Fixed::at).collect();
    let (mut asked, mut met, mut crossed) = (0, 0, 0);
    for b in [20, 16, 10, 6, 4, 2, 1] {
        let grid =
            Grid::around(scene.iter().flatten().copied(), Bits::of_grid(b).unwrap()).unwrap();
        let corners: Vec<_> = scene.iter().map(|t| t.map(|c| grid.snap(c).unwrap())).collect();
        let triangles: Vec<Triangle> =
            corners.iter().map(|&t| grid.triangle_of(t).unwrap()).collect();
        let bvh = GridBvh::new(&triangles);
        let blocks = blocks(&triangles);

        // Generate bounded and unbounded rays: exactly toward corners, toward edge midpoints, along
        // axes, from corners, and in random directions. Some are snapped from f32 rays, so their t
        // is in a different unit.
        let rays: Vec<_> = (0..1_200)
            .filter_map(|i| {
                let to = corners[i * 37 % corners.len()];
                let from = match i % 3 {
                    0 => n.one_of(&corners)[0],
                    _ => n.vector(1 << b),
                };
                let dir = match i % 5 {
                    0 => sub(to[0], from),
                    1 => add(sub(to[0], from), sub(to[1], from)),
                    2 => n.one_of(&[[1, 0, 0], [0, -1, 0], [0, 0, 1], [0, 3, -1]]),
                    _ => n.vector(1 << grid.bits().q().min(b + 1)),
                };
                let ray = if i % 4 == 0 {
                    let origin = grid.unsnap(from).map(|x| x as f32);
                    grid.ray(&Ray::new(origin, dir.map(|x| x as f32 * 3e-7))).ok()?
                } else {
                    grid.ray_of(from, dir).ok()?
                };
                // Test intervals that end at or just behind a hit, intervals that begin just behind
                // a hit, and an empty interval.
                let hit = Fixed::default().closest(&blocks, &ray);
                let t = hit.map_or(1.0, |hit| hit.t as f32);
                Some(match i % 8 {
                    1 => ray.between(0.0, t),
                    3 => ray.between(0.0, t.next_up()),
                    5 => ray.between(t.next_up(), f32::INFINITY),
                    7 if i % 16 == 7 => ray.between(t, t),
                    _ => ray,
                })
            })
            .collect();

        for (i, ray) in rays.iter().enumerate() {
            // Alternate between the levels, which must return the same results.
            let mode = &levels[i % levels.len()];
            let want = expected(ray, &triangles);
            let all: Vec<Hit> = want.iter().map(|crossing| crossing.hit).collect();
            let closest = all.first().copied();
            assert_eq!(mode.closest(&blocks, ray), closest, "{b} {ray:?}");
            let mut query = bvh.query(mode.level());
            assert_eq!(query.closest(ray), closest, "{b} {ray:?}");
            assert_eq!(query.any(ray), closest.is_some(), "{b} {ray:?}");
            assert_eq!(query.all(ray), all, "{b} {ray:?}");
            assert_eq!(query.crossings(ray), want, "{b} {ray:?}");
            met += usize::from(closest.is_some());
            crossed += all.len();
        }
        let query = bvh.query(Level::best());
        let (hits, any) = (query.closest_batch(&rays), query.any_batch(&rays));
        let counts = query.count_crossings_batch(&rays);
        for (((ray, hit), any), count) in rays.iter().zip(hits).zip(any).zip(counts) {
            let one = levels[0].closest(&blocks, ray).unwrap_or(Hit::MISS);
            assert_eq!((hit, any), (one, hit.is_hit()), "{b} {ray:?}");
            assert_eq!(count, levels[0].crossings(&blocks, ray), "{b} {ray:?}");
        }
        asked += rays.len();
    }
    println!("{asked} rays, {met} hit something, {crossed} crossings");
    assert!(asked > 7_000 && met > 3_000 && crossed > 5_000, "{asked} {met} {crossed}");
}

#[test]
fn a_hierarchy_over_nothing_or_over_points_has_no_hits() {
    let grid = Grid::at(Bits::FINE, 0, [0; 3]).unwrap();
    let point = grid.triangle_of([[3, 0, 0]; 3]).unwrap();
    let ray = grid.ray_of([0; 3], [1, 0, 0]).unwrap();
    for triangles in [vec![], vec![point; 20]] {
        let bvh = GridBvh::new(&triangles);
        let mut query = bvh.query(Level::best());
        assert_eq!(query.closest(&ray), None);
        assert!(!query.any(&ray) && query.all(&ray).is_empty());
        assert!(query.crossings(&ray).is_empty());
        assert_eq!(query.count_crossings_batch(&[ray]), [Crossings::default()]);
    }
}

/// Two nearly coplanar triangles are folded onto each other along a common edge. Rays pass so close
/// to the edge that the values of t at both triangles round to the same f64 although they differ.
/// The exact ratios must decide which hit comes first.
#[test]
fn t_that_round_alike_are_compared_as_ratios() {
    let mut n = Numbers(7);
    let grid = Grid::at(Bits::FINE, 0, [0; 3]).unwrap();
    let mut found = 0;
    for _ in 0..200 {
        let (a, b, c) = (n.vector(1 << 19), n.vector(1 << 19), n.vector(1 << 19));
        let lifted = [c[0], c[1], c[2] + 1];
        let origin = n.vector(1 << 19);
        let pair = [[a, b, c], [a, b, lifted]].map(|corners| grid.triangle_of(corners).unwrap());

        // Generate many rays toward the edge, so that some of them pass very close to it.
        let mut rays = Vec::new();
        for step in 1..30_000 {
            let s = f64::from(step) / 30_000.0;
            let to = [0, 1, 2]
                .map(|k| f64::from(a[k]) * s + f64::from(b[k]) * (1.0 - s) - f64::from(origin[k]));
            let longest = to.iter().fold(0.0_f64, |most, x| most.max(x.abs()));
            let dir = to.map(|x| (x / longest * 262_143.0).round() as i32);
            let ray = grid.ray_of(origin, dir).unwrap();
            let t = pair.map(|triangle| crossing(&ray, &triangle).map(|at| at.t));
            if let [Some(first), Some(second)] = t
                && first != second
                && first.to_f64(0) == second.to_f64(0)
            {
                rays.push((ray, usize::from(second < first)));
            }
        }
        found += rays.len();

        // Test both orders of the triangles, each with single rays and with a batch, which is a
        // bundle because its rays share an origin.
        for turned in [false, true] {
            let triangles = if turned { [pair[1], pair[0]] } else { pair };
            let bvh = GridBvh::new(&triangles);
            let lines: Vec<_> = rays.iter().flat_map(|(ray, _)| [*ray; 4]).collect();
            let mut query = bvh.query(Level::best());
            let hits = query.closest_batch(&lines);
            for ((ray, first), hits) in rays.iter().zip(hits.chunks(4)) {
                let nearer = (first ^ usize::from(turned)) as u32;
                assert_eq!(query.closest(ray).map(|hit| hit.triangle), Some(nearer));
                assert!(hits.iter().all(|hit| hit.triangle == nearer), "{ray:?}");
            }
        }
    }
    assert!(found > 100, "{found}");
}
