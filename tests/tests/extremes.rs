//! Tests the public API with extreme coordinates. Queries must not panic, hang or lose hits.

use std::panic::{AssertUnwindSafe, catch_unwind};

use intertri::fixed::{Bits, Fixed, Grid, blocks};
use intertri::simd::Level;
use intertri::{Mode, Ray, Triangle};
use intertri_tests::{Scene, check_hierarchy, check_kernel};
use intertri_trace::Bvh;

/// Compares the kernel and the hierarchy with the reference. Returns the number of hits in the
/// scene.
fn hits(triangles: Vec<Triangle>, rays: Vec<Ray>, threshold: f64) -> usize {
    let scene = Scene { triangles, rays, threshold };
    let levels: Vec<Level> = Level::all().collect();
    let hits = check_kernel(&scene, &levels).unwrap_or_else(|why| panic!("{why}"));
    check_hierarchy(&scene, &levels).unwrap_or_else(|why| panic!("{why}"));
    hits
}

/// Returns rays along z through the centres of the squares of a 4×4 board with side length `s`.
fn through_a_board(s: f32, from: f32, dir: f32) -> Vec<Ray> {
    let at = |i: i32| s * ((i as f32 + 0.5) / 4.0 - 0.5);
    let ray = |i| Ray::new([at(i % 4), at(i / 4), from], [0.0, 0.0, dir]);
    (0..16).map(ray).collect()
}

/// Returns the 32 triangles of a 4×4 board with side length `s` in the plane z = 0.
fn board(s: f32) -> Vec<Triangle> {
    let at = |i: i32| s * (i as f32 / 4.0 - 0.5);
    let square = |i: i32| {
        let (x, y) = (i % 4, i / 4);
        let p = |dx: i32, dy: i32| [at(x + dx), at(y + dy), 0.0];
        [Triangle([p(0, 0), p(1, 0), p(0, 1)]), Triangle([p(1, 0), p(1, 1), p(0, 1)])]
    };
    (0..16).flat_map(square).collect()
}

#[test]
fn every_size_of_scene_that_f32_has() {
    // The centre of a square lies on its diagonal, so both of its triangles are hit.
    for exponent in [-140, -126, -100, -40, 0, 40, 100, 126] {
        let s = (exponent as f32).exp2();
        assert_eq!(hits(board(s), through_a_board(s, -s, s), 0.0), 32, "2^{exponent}");
    }
    // Three eighths of `f32::MAX` is not exactly an f32, so most rays miss the diagonals and hit
    // only one of the two triangles.
    let max = f32::MAX;
    assert_eq!(hits(board(max), through_a_board(max, -max, max), 0.0), 22);
}

#[test]
fn the_corners_of_the_range() {
    let max = f32::MAX;
    let corner = |i: usize| [0, 1, 2].map(|axis| if i >> axis & 1 == 0 { -max } else { max });
    let mut triangles = Vec::new();
    for i in 0..8 {
        for j in 0..8 {
            for k in 0..8 {
                triangles.push(Triangle([corner(i), corner(j), corner(k)]));
            }
        }
    }
    let rays: Vec<Ray> = (0..8)
        .flat_map(|i| [Ray::new([0.0; 3], corner(i)), Ray::new(corner(i), corner(7 - i))])
        .chain([Ray::new([0.0; 3], [1.0, 2.0, 3.0]), Ray::new([1e-45; 3], [1e-45, 0.0, 0.0])])
        .collect();
    assert!(hits(triangles, rays, 0.0) > 0);
}

#[test]
fn identical_and_collinear_triangles() {
    let ray = || Ray::new([0.25, 0.25, -1.0], [0.0, 0.0, 1.0]);
    let one = Triangle([[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]);
    assert_eq!(hits(vec![one; 50], vec![ray()], 1e-9), 50);
    let line = |i: i32| Triangle([i - 1, i, i + 7].map(|x| [x as f32, 2.0 * x as f32, 0.5]));
    let along = Ray::new([-9.0, -18.0, 0.5], [1.0, 2.0, 0.0]);
    let across = Ray::new([0.0, 0.0, 0.0], [0.0, 0.0, 1.0]);
    assert_eq!(hits((0..50).map(line).collect(), vec![along, across], 0.0), 0);
}

#[test]
fn the_grid_at_the_ends_of_f32() {
    let max = f32::MAX;
    for s in [f32::from_bits(1 << 12), 1.0, max] {
        let points = board(s).into_iter().flat_map(|t| t.0).chain([[0.0, 0.0, -s], [0.0, 0.0, s]]);
        // The grid's step is at least 2^-149, and its side is at most half of the range of f32.
        match Grid::around(points, Bits::FINE) {
            Ok(grid) => {
                let triangles: Vec<_> =
                    board(s).iter().map(|t| grid.triangle(t).unwrap()).collect();
                let blocks = blocks(&triangles);
                for ray in through_a_board(s, -s, s) {
                    let count = Fixed::default().crossings(&blocks, &grid.ray(&ray).unwrap());
                    assert_eq!(count.unsigned, 1, "{s:e} {ray:?}");
                }
            }
            Err(error) => assert!(!error.to_string().is_empty() && s != 1.0, "{s:e}: {error}"),
        }
    }
    for bad in [f32::NAN, f32::INFINITY] {
        assert!(Grid::around([[bad, 0.0, 0.0]], Bits::FINE).is_err());
    }
}

#[test]
fn a_panic_in_one_job_ends_the_build_and_hangs_nobody() {
    let triangles = board(1.0).repeat(2_000);
    let build = || Bvh::with_progress(&triangles, &|_, _| panic!("panics on purpose")).map(|_| ());
    assert!(catch_unwind(AssertUnwindSafe(build)).is_err());
    // The thread pool still works for the next query.
    let bvh = Bvh::new(&triangles).unwrap();
    let ray = &through_a_board(1.0, -1.0, 1.0)[5];
    assert_eq!(bvh.query().mode(Mode::certified()).all(ray).len(), 4_000);
}
