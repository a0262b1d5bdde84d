//! Traces bundles of rays that start at the same grid point. The results must equal those of a
//! plain loop.

use intertri::Hit;
use intertri::Ray as Line;
use intertri::fixed::{Bits, Fixed, Grid, Ray, Triangle, blocks};
use intertri::simd::Level;

use super::{GridBvh, Numbers, add, hierarchy, sub};

type Corners = [[i32; 3]; 3];

/// Generates the scene of the hierarchy test and adds a sheet of squares. Some of the sheet's
/// triangles are duplicated with rotated or flipped corners, or covered by a larger triangle in the
/// same plane, so that different integers yield the same t.
fn scene(n: &mut Numbers, grid: &Grid) -> Vec<Corners> {
    let mut all: Vec<Corners> =
        hierarchy::scene(n).iter().map(|t| t.map(|c| grid.snap(c).unwrap())).collect();
    let (limit, step) = (1 << grid.bits().b(), (1 << grid.bits().b() >> 4).max(1));
    for i in 0..200 {
        let at =
            |x: i32, y: i32| [limit / 2, x * step, (y - 7) * step].map(|k| k.clamp(-limit, limit));
        let (x, y) = (i % 14, i / 14);
        let [a, b, c, d] = [at(x, y), at(x + 1, y), at(x, y + 1), at(x + 1, y + 1)];
        all.extend([[a, b, c], [d, c, b]]);
        match i % 9 {
            0 => all.push([b, c, a]),
            1 => all.push([a, c, b]),
            2 => all.push([a, at(x + 2, y), at(x, y + 2)]),
            _ => {}
        }
    }
    all
}

/// Generates rays from one origin in a narrow cone. They go exactly toward corners and edge
/// midpoints, lie on a raster, or are scattered.
fn coherent(n: &mut Numbers, grid: &Grid, scene: &[Corners], kind: usize) -> Option<Vec<Ray>> {
    let (b, q) = (1 << grid.bits().b(), 1 << grid.bits().q());
    let place = n.below(scene.len() as u64) as usize;
    let t = scene[place];

    // Start at a random point, far away, in the plane of a triangle, next to that plane, or at a
    // corner.
    let along = add(t[0], sub(t[1], t[2]));
    let origin = match kind % 5 {
        0 => add(t[0], n.vector(b.min(q))),
        1 => n.one_of(&[[-b, -b, b], [-b, 0, 0], [b, b, b]]),
        2 => along,
        3 => add(along, n.vector(1)),
        _ => n.one_of(scene)[0],
    }
    .map(|x| x.clamp(-b, b));

    // The axis of the cone uses as many bits as a direction may have.
    let longest = |d: [i32; 3]| d[0].abs().max(d[1].abs()).max(d[2].abs());
    let mut middle = sub(t[1], origin);
    while longest(middle) > q {
        middle = middle.map(|x| x / 2);
    }
    if middle == [0; 3] {
        return None;
    }
    while 2 * longest(middle) <= q {
        middle = middle.map(|x| 2 * x);
    }
    let dot = |a: [i32; 3], b: [i32; 3]| (0..3).map(|k| f64::from(a[k]) * f64::from(b[k])).sum();
    let near = |d: [i32; 3]| {
        let (across, a, b): (f64, f64, f64) = (dot(d, middle), dot(d, d), dot(middle, middle));
        longest(d) <= q && across > 0.98 * (a * b).sqrt()
    };

    let spread = (longest(middle) >> n.below(16)).max(2) / 2;
    let most = if kind % 4 == 3 { 1499 } else { 299 };
    let rays = (0..2 + n.below(most) as usize).filter_map(|i| {
        let beside = scene[(place + n.below(30) as usize) % scene.len()];
        let [from, to] = [sub(beside[0], origin), sub(beside[1], origin)];
        let raster = [0, i as i32 % 16, i as i32 / 16].map(|k| k * spread / 16);
        let dir = match n.below(4) {
            0 if near(from) => from,
            1 if near(add(from, to)) => add(from, to),
            2 => add(middle, n.vector(spread)),
            _ => add(middle, raster),
        };
        let dir = if longest(dir) > q { middle } else { dir };
        if kind.is_multiple_of(4) {
            let origin = grid.unsnap(origin).map(|x| x as f32);
            grid.ray(&Line::new(origin, dir.map(|x| x as f32 * 3e-7))).ok()
        } else {
            grid.ray_of(origin, dir).ok()
        }
    });
    Some(rays.collect())
}

#[test]
fn bundles_answer_as_the_queries_over_all_triangles() {
    let mut n = Numbers(12);
    let levels: Vec<Fixed> = Level::all().map(Fixed::at).collect();
    let (mut asked, mut met) = (0, 0);
    for b in [20, 18, 16, 10, 6, 4, 2] {
        let bits = Bits::of_grid(b).unwrap();
        let grid = Grid::around([[-1.0; 3], [1.0; 3]], bits).unwrap();
        let corners = scene(&mut n, &grid);
        let triangles: Vec<Triangle> =
            corners.iter().map(|&t| grid.triangle_of(t).unwrap()).collect();
        let (bvh, blocks) = (GridBvh::new(&triangles), blocks(&triangles));
        for kind in 0..240 {
            let Some(mut rays) = coherent(&mut n, &grid, &corners, kind) else { continue };
            // Kinds that differ by a multiple of 60 are equivalent, so each kind is tested at every
            // level.
            let mode = &levels[kind / 60 % levels.len()];
            let closest = |rays: &[Ray]| -> Vec<Hit> {
                rays.iter().map(|ray| mode.closest(&blocks, ray).unwrap_or(Hit::MISS)).collect()
            };

            // Test intervals that end just before, at, or just behind a hit, intervals that begin
            // at or just behind a hit, and an empty interval.
            let mut want = closest(&rays);
            if kind % 3 == 0 {
                for (i, (ray, hit)) in rays.iter_mut().zip(&want).enumerate() {
                    let t = if hit.is_hit() { hit.t as f32 } else { 1.0 };
                    *ray = match i % 7 {
                        0 => ray.between(0.0, t.next_down()),
                        1 => ray.between(0.0, t),
                        2 => ray.between(0.0, t.next_up()),
                        3 => ray.between(t, f32::INFINITY),
                        4 => ray.between(t.next_up(), f32::INFINITY),
                        5 => ray.between(t, t),
                        _ => *ray,
                    };
                }
                want = closest(&rays);
            }

            let query = bvh.query(mode.level());
            let (hits, any) = (query.closest_batch(&rays), query.any_batch(&rays));
            for (((ray, want), hit), any) in rays.iter().zip(want).zip(hits).zip(any) {
                assert_eq!((hit, any), (want, want.is_hit()), "{b} {kind} {mode:?} {ray:?}");
                met += usize::from(hit.is_hit());
            }
            asked += rays.len();
        }
    }
    println!("{asked} rays, {met} hit something");
    assert!(asked > 200_000 && met > 80_000, "{asked} {met}");
}
