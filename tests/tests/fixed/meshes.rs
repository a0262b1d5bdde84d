//! Tests closed meshes: a ray that starts inside must leave the mesh exactly once more often than
//! it enters, even at corners and edges.

use std::path::PathBuf;

use intertri::fixed::{Bits, Fixed, Grid, Triangle, blocks};
use intertri::{Blocks, Hit};
use intertri_tests::{grid_reference, is_on};

use super::solids::{icosphere, is_closed, octahedron};
use super::{Numbers, add, sub};

/// Loads a model from the shared folder, or returns `None` if it does not exist.
fn model(name: &str) -> Option<Vec<[[f32; 3]; 3]>> {
    let folder = std::env::var_os("INTERTRI_MODELS").map_or_else(
        || PathBuf::from(concat!(env!("CARGO_MANIFEST_DIR"), "/../../shared/models")),
        PathBuf::from,
    );
    let path = folder.join(name);
    if !path.exists() {
        println!("{} does not exist: not tested", path.display());
        return None;
    }
    let mesh = intertri_scene::load(&path).unwrap();
    Some(mesh.to_triangles().into_iter().map(|t| t.0).collect())
}

/// Returns whether a snapped triangle is degenerate.
fn is_degenerate([a, b, c]: [[i32; 3]; 3]) -> bool {
    let (e, f) = (sub(b, a).map(i64::from), sub(c, a).map(i64::from));
    (0..3).all(|i| {
        let (j, k) = ((i + 1) % 3, (i + 2) % 3);
        e[j] * f[k] == e[k] * f[j]
    })
}

/// The amount of work that a test does. The long test does more than the ordinary one.
#[derive(Clone, Copy)]
struct Effort {
    /// Rays are aimed at the corners and edges of one out of this many triangles.
    every: usize,
    /// The number of random rays.
    random: usize,
    /// The number of points inside the mesh from which rays start.
    points: usize,
}

/// Casts rays from a point inside: toward corners, toward edge midpoints, and in random directions.
/// Each ray must leave the mesh once more often than it enters. Returns the number of rays.
fn cast(
    n: &mut Numbers,
    grid: &Grid,
    mesh: &[[[i32; 3]; 3]],
    origin: [i32; 3],
    effort: Effort,
) -> usize {
    let triangles: Vec<Triangle> = mesh.iter().map(|&t| grid.triangle_of(t).unwrap()).collect();
    let blocks = blocks(&triangles);
    let fixed = Fixed::default();
    let mut rays = 0;
    let mut check = |dir: [i32; 3]| {
        if dir == [0; 3] {
            return;
        }
        let ray = grid.ray_of(origin, dir).unwrap();
        let count = fixed.crossings(&blocks, &ray);
        assert_eq!(count.signed, 1, "{origin:?} {dir:?} {count:?}");
        rays += 1;
    };
    for corners in mesh.iter().step_by(effort.every) {
        for k in 0..3 {
            let [from, to] = [corners[k], corners[(k + 1) % 3]].map(|c| sub(c, origin));
            check(from);
            check(add(from, to));
        }
    }
    for _ in 0..effort.random {
        let long = n.one_of(&[1, 3, grid.bits().q()]);
        check(n.vector(1 << long));
    }
    rays
}

/// Snaps a mesh to grids from fine to coarse, and casts rays from points inside it.
fn on_grids(
    name: &str,
    mesh: &[[[f32; 3]; 3]],
    insides: &[[f32; 3]],
    bits: &[u32],
    effort: Effort,
) -> usize {
    let mut n = Numbers(99);
    let mut rays = 0;
    for &b in bits {
        // A direction must have enough bits for the sum of two vectors across the grid.
        let bits = Bits::new(b, (58 - 2 * b).min(24)).unwrap();
        assert!(bits.q() >= b + 2);
        let grid = Grid::around(mesh.iter().flatten().copied(), bits).unwrap();
        let snapped: Vec<_> = mesh.iter().map(|t| t.map(|c| grid.snap(c).unwrap())).collect();
        assert!(is_closed(&snapped), "{name} is not closed");
        let flat = snapped.iter().filter(|&&t| is_degenerate(t)).count();

        // On a coarse grid, snapping moves the surface, possibly onto a point or past it. For all
        // other points, one ray determines whether they are inside, and all rays must agree.
        let triangles: Vec<_> = snapped.iter().map(|&t| grid.triangle_of(t).unwrap()).collect();
        let blocks = blocks(&triangles);
        let is_inside = |p: &&[f32; 3]| {
            let at = grid.snap(**p).unwrap();
            let winding = Fixed::default().winding(&blocks, &grid, **p).unwrap();
            winding == 1 && !snapped.iter().any(|&t| is_on(at, t))
        };
        let still: Vec<_> = insides.iter().filter(is_inside).collect();
        assert!(!still.is_empty() && (b < 12 || still.len() == insides.len()), "{name} {b}");
        for &&inside in &still {
            rays += cast(&mut n, &grid, &snapped, grid.snap(inside).unwrap(), effort);
        }
        let all = mesh.len();
        println!("{name} b={b}: {flat} of {all} with zero area, from {} points", still.len());
    }
    rays
}

fn all_meshes(fine: u32, effort: Effort) -> usize {
    let mut rays = 0;
    let Effort { every, random, points } = effort;
    let sphere = icosphere(fine);
    let around: Vec<[f32; 3]> = [[0.0; 3], [0.25, -0.125, 0.5], [0.1, 0.2, 0.3], [-0.5, 0.5, 0.0]]
        .into_iter()
        .take(points)
        .collect();
    let all = Effort { every: 1, ..effort };
    rays += on_grids("icosphere", &sphere, &around, &[18, 16, 10, 6, 4, 3, 2], all);
    let fewer = Effort { every, random: random / 8, points };
    for (name, bits) in [("fandisk.obj", [18, 9, 6, 5]), ("spot.obj", [18, 7, 5, 4])] {
        if let Some(mesh) = model(name) {
            rays += on_grids(name, &mesh, &inside_of(&mesh, points), &bits, fewer);
        }
    }
    println!("{rays} rays, each with a signed count of 1");
    rays
}

/// Returns points below faces, at a depth of about a hundredth of the mesh's size. The points
/// around them also have winding number 1.
fn inside_of(mesh: &[[[f32; 3]; 3]], points: usize) -> Vec<[f32; 3]> {
    let grid = Grid::around(mesh.iter().flatten().copied(), Bits::FINE).unwrap();
    let snapped: Vec<_> =
        mesh.iter().map(|&t| grid.triangle(&intertri::Triangle(t)).unwrap()).collect();
    let blocks = blocks(&snapped);
    let fixed = Fixed::default();
    let deep = grid.step() as f32 * 2.0_f32.powi(14);
    let inside = |p: [f32; 3]| fixed.winding(&blocks, &grid, p).is_ok_and(|winding| winding == 1);
    mesh.iter()
        .step_by(mesh.len() / 97)
        .map(|[a, b, c]| {
            let [e, f] = [b, c].map(|p| [0, 1, 2].map(|i| p[i] - a[i]));
            let normal = [0, 1, 2].map(|i| {
                let (j, k) = ((i + 1) % 3, (i + 2) % 3);
                e[j] * f[k] - e[k] * f[j]
            });
            let length = normal.iter().map(|x| x * x).sum::<f32>().sqrt();
            [0, 1, 2].map(|i| (a[i] + b[i] + c[i]) / 3.0 - 3.0 * deep * normal[i] / length)
        })
        .filter(|&p| {
            // All neighbouring points must also be inside, because snapping to coarse grids moves
            // the surface.
            (0..27).all(|k| {
                let way = [k % 3, k / 3 % 3, k / 9].map(|x| (x - 1) as f32 * deep);
                inside([0, 1, 2].map(|i| p[i] + way[i]))
            })
        })
        .take(points)
        .collect()
}

#[test]
fn a_ray_from_inside_of_a_closed_mesh_crosses_once() {
    let rays = all_meshes(3, Effort { every: 16, random: 2_000, points: 3 });
    assert!(rays > 100_000);
}

#[test]
#[ignore = "takes a minute: more than five million rays"]
fn a_ray_from_inside_of_a_closed_mesh_crosses_once_for_long() {
    let rays = all_meshes(3, Effort { every: 1, random: 240_000, points: 4 });
    assert!(rays > 5_000_000, "{rays}");
}

/// The octahedron |x| + |y| + |z| <= r is a solid with many coplanar triangles in each face.
#[test]
fn points_are_inside_of_an_octahedron_where_its_formula_says_so() {
    let grid = Grid::at(Bits::FINE, 0, [0; 3]).unwrap();
    let (cells, cell) = (8, 3);
    let mesh = octahedron(cells, cell);
    assert!(is_closed(&mesh));
    let triangles: Vec<_> = mesh.iter().map(|&t| grid.triangle_of(t).unwrap()).collect();
    let blocks = blocks(&triangles);
    let fixed = Fixed::default();
    let r = cells * cell;
    let (mut inside, mut outside) = (0, 0);
    for x in -r - 1..=r + 1 {
        for y in -r - 1..=r + 1 {
            for z in -r - 1..=r + 1 {
                let distance = x.abs() + y.abs() + z.abs();
                let winding = fixed.winding(&blocks, &grid, [x, y, z].map(|x| x as f32)).unwrap();
                let contains = fixed.contains(&blocks, &grid, [x, y, z].map(|x| x as f32)).unwrap();
                assert_eq!(contains, winding == 1, "{winding}");
                // On the surface, either result is allowed.
                if distance != r {
                    assert_eq!(contains, distance < r, "{x} {y} {z}");
                }
                inside += usize::from(contains);
                outside += usize::from(!contains);
            }
        }
    }
    println!("{inside} points inside, {outside} outside");
    assert!(inside > 10_000 && outside > 10_000);
    assert!(fixed.contains(&blocks, &grid, [f32::NAN; 3]).is_err());
    assert!(fixed.contains(&blocks, &grid, [1e9; 3]).is_err());
}

#[test]
fn turning_or_flipping_triangles_changes_no_unsigned_answer() {
    let mut n = Numbers(5);
    let grid = Grid::at(Bits::new(17, 24).unwrap(), 0, [0; 3]).unwrap();
    let fixed = Fixed::default();
    let mut mesh: Vec<_> = icosphere(2)
        .into_iter()
        .map(|t| t.map(|c| c.map(|x| (x * 1000.0).round() as i32)))
        .collect();
    mesh.extend((0..200).map(|_| [n.vector(3), n.vector(3), n.vector(3)]));
    let make = |mesh: &[[[i32; 3]; 3]]| {
        let triangles: Vec<_> = mesh.iter().map(|&t| grid.triangle_of(t).unwrap()).collect();
        blocks(&triangles)
    };
    let same = make(&mesh);
    let turned = make(&mesh.iter().map(|&[a, b, c]| [b, c, a]).collect::<Vec<_>>());
    let flipped = make(&mesh.iter().map(|&[a, b, c]| [b, a, c]).collect::<Vec<_>>());
    let mut hits = 0;
    for round in 0..3_000 {
        let reach = n.one_of(&[2, 500, 2000]);
        let origin = n.vector(reach);
        let corners = n.one_of(&mesh);
        let dir = match round % 3 {
            0 => sub(corners[0], origin),
            1 => add(sub(corners[0], origin), sub(corners[1], origin)),
            _ => n.vector(1000),
        };
        let Ok(ray) = grid.ray_of(origin, dir) else { continue };
        let answer = |blocks: &Blocks| {
            let told = |hit: &Hit| (hit.triangle, hit.t);
            let closest = fixed.closest(blocks, &ray).as_ref().map(told);
            let all: Vec<_> = fixed.all(blocks, &ray).iter().map(told).collect();
            (closest, fixed.any(blocks, &ray), all)
        };
        let count = fixed.crossings(&same, &ray);
        let [turned_count, flipped_count] = [&turned, &flipped].map(|b| fixed.crossings(b, &ray));
        assert_eq!(count, turned_count);
        assert_eq!((count.signed, count.unsigned), (-flipped_count.signed, flipped_count.unsigned));
        assert_eq!(answer(&same), answer(&turned));
        assert_eq!(answer(&same), answer(&flipped));
        hits += count.unsigned;
    }
    assert!(hits > 3_000, "{hits}");
}

#[test]
fn equal_t_go_to_the_lowest_index() {
    let mut n = Numbers(6);
    let grid = Grid::at(Bits::FINE, 0, [0; 3]).unwrap();
    let mesh: Vec<_> = (0..40).map(|_| [n.vector(99), n.vector(99), n.vector(99)]).collect();
    // Repeat all triangles in a different order with rotated corners, so that duplicates are far
    // apart in the slice.
    let again = mesh.iter().rev().map(|&[a, b, c]| [c, a, b]);
    let scene: Vec<Triangle> = (mesh.iter().copied().chain(again).chain(mesh.iter().copied()))
        .map(|t| grid.triangle_of(t).unwrap())
        .collect();
    let blocks = blocks(&scene);
    let fixed = Fixed::default();
    let rays: Vec<_> = (0..800)
        .map(|i| {
            let origin = if i < 400 { n.vector(200) } else { [7, 8, 300] };
            grid.ray_of(origin, sub(n.vector(20), origin)).unwrap()
        })
        .collect();
    let mut hits = vec![Hit::MISS; rays.len()];
    fixed.closest_batch(&blocks, &rays, &mut hits);
    let mut count = 0;
    for (ray, hit) in rays.iter().zip(hits) {
        assert_eq!(hit, fixed.closest(&blocks, ray).unwrap_or(Hit::MISS));
        if hit.is_hit() {
            assert!(hit.triangle < 40, "{hit:?}");
            let all = fixed.all(&blocks, ray);
            assert!(all.len() >= 3 && all.iter().all(|other| other.t >= hit.t));
            count += 1;
        }
    }
    assert!(count > 200, "{count}");
}

/// Two triangles share an edge, and their far corners differ by one grid step. Near the edge, the
/// relative difference between the values of t is about `2^-58`, which f64 cannot resolve.
#[test]
fn t_that_f64_cannot_tell_apart_are_compared_exactly() {
    let mut n = Numbers(9);
    let grid = Grid::at(Bits::FINE, 0, [0; 3]).unwrap();
    let fixed = Fixed::default();
    let (mut equal_in_f64, mut first) = (0, 0);
    for _ in 0..500 {
        let h = 500 + n.within(400);
        let (a, b) = ([-(1 << 19), 0, h], [(1 << 19) - 1, 0, h + 1]);
        let far = |x| grid.triangle_of([a, b, [x, 1 << 20, h]]).unwrap();
        let x = n.within(1000);
        let scene = if n.below(2) == 0 { [far(x), far(x + 1)] } else { [far(x + 1), far(x)] };
        let ray = grid.ray_of([0; 3], [n.within(1 << 17), 1, (1 << 18) - 1]).unwrap();

        let [p, q] = scene.map(|t| grid_reference::crossing(&ray, &t).unwrap().t);
        let nearer = u32::from(p.num * u128::from(q.den) > q.num * u128::from(p.den));
        equal_in_f64 += usize::from(p.to_f64(0) == q.to_f64(0) && nearer == 1);
        first += usize::from(nearer == 0);

        let blocks = blocks(&scene);
        assert_eq!(fixed.closest(&blocks, &ray).unwrap().triangle, nearer, "{scene:?} {ray:?}");
    }
    assert!(equal_in_f64 > 50 && first > 50, "{equal_in_f64} {first}");
}
