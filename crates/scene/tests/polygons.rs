//! Tests that polygons become triangles that cover exactly the same area.

use std::collections::HashMap;
use std::fmt::Write;
use std::fs;

use intertri_scene::{Coordinate, LoadedModel, load_model};
use tempfile::TempDir;

type Point = [f64; 3];

/// Returns the triangles of one polygon, as indices into the polygon's corners, and the notes about
/// the polygon.
fn cut<S: Coordinate>(corners: &[Point]) -> (Vec<[usize; 3]>, Vec<String>) {
    let mut text = String::new();
    for [x, y, z] in corners {
        writeln!(text, "v {x:e} {y:e} {z:e}").unwrap();
    }
    text.push('f');
    (1..=corners.len()).for_each(|corner| write!(text, " {corner}").unwrap());
    let folder = TempDir::new().unwrap();
    let path = folder.path().join("a.obj");
    fs::write(&path, text).unwrap();
    let LoadedModel::<S> { mesh, notes, .. } = load_model(&path).unwrap();
    let triangles = mesh.triangles.iter().map(|triangle| triangle.map(|i| i as usize)).collect();
    (triangles, notes.as_slice().iter().map(ToString::to_string).collect())
}

fn cross([a, b, c]: [Point; 3]) -> Point {
    let [u, v] = [b, c].map(|p| [0, 1, 2].map(|k| p[k] - a[k]));
    [u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]]
}

/// Checks a cut: the number of triangles is correct, the open edges are exactly the edges of the
/// polygon, and all areas have the same sign, so that they add up to the polygon's area.
#[track_caller]
fn check(corners: &[Point], triangles: &[[usize; 3]]) {
    let count = corners.len();
    assert_eq!(triangles.len(), count - 2, "{corners:?}");
    let mut edges = HashMap::new();
    for &[a, b, c] in triangles {
        for (from, to) in [(a, b), (b, c), (c, a)] {
            *edges.entry((from, to)).or_insert(0) += 1;
        }
    }
    for (&(from, to), &times) in &edges {
        assert_eq!(times, 1, "edge {from}-{to} of {triangles:?}");
        let is_free = !edges.contains_key(&(to, from));
        assert_eq!(is_free, to == (from + 1) % count, "edge {from}-{to} of {triangles:?}");
    }
    let normals: Vec<Point> =
        triangles.iter().map(|triangle| cross(triangle.map(|i| corners[i]))).collect();
    let sum = [0, 1, 2].map(|k| normals.iter().map(|n| n[k]).sum::<f64>());
    let length = |n: Point| n.iter().map(|x| x * x).sum::<f64>().sqrt();
    let area: f64 = normals.iter().map(|&n| length(n)).sum();
    assert!(area <= length(sum) * (1.0 + 1e-6), "{area} is not {sum:?} of {corners:?}");
}

/// Places a flat polygon in space, rotated and with the given size and position.
fn put(corners: &[[f64; 2]], size: f64, place: Point) -> Vec<Point> {
    let (across, up) = ([0.6, 0.48, 0.64], [-0.8, 0.36, 0.48]);
    let point =
        |&[x, y]: &[f64; 2]| [0, 1, 2].map(|k| (x * across[k] + y * up[k]) * size + place[k]);
    corners.iter().map(point).collect()
}

fn flat(corners: &[[f64; 2]]) -> Vec<Point> {
    corners.iter().map(|&[x, y]| [x, y, 0.0]).collect()
}

/// Returns the polygon starting from each of its corners, in both directions.
fn turns(corners: &[[f64; 2]]) -> impl Iterator<Item = Vec<[f64; 2]>> {
    (0..2 * corners.len()).map(|turn| {
        let mut turned = corners.to_vec();
        turned.rotate_left(turn / 2);
        if turn % 2 == 1 {
            turned.reverse();
        }
        turned
    })
}

const DART: [[f64; 2]; 4] = [[0.0, 0.0], [1.0, 0.0], [0.2, 0.2], [0.0, 1.0]];

/// A square with a square hole, which a cut between two corners connects to the border.
const KEYHOLE: [[f64; 2]; 10] = [
    [0.0, 0.0],
    [3.0, 0.0],
    [3.0, 3.0],
    [0.0, 3.0],
    [0.0, 0.0],
    [1.0, 1.0],
    [1.0, 2.0],
    [2.0, 2.0],
    [2.0, 1.0],
    [1.0, 1.0],
];

/// An L whose straight edges have corners at their midpoints, where a neighbour's edges may end.
const STRAIGHT: [[f64; 2]; 10] = [
    [0.0, 0.0],
    [1.0, 0.0],
    [2.0, 0.0],
    [2.0, 1.0],
    [1.5, 1.0],
    [1.0, 1.0],
    [1.0, 2.0],
    [0.5, 2.0],
    [0.0, 2.0],
    [0.0, 0.5],
];

#[test]
fn concave_polygons_are_covered_and_nothing_else() {
    for polygon in [&DART[..], &KEYHOLE, &STRAIGHT] {
        for turned in turns(polygon) {
            let (triangles, notes) = cut::<f32>(&flat(&turned));
            assert_eq!(notes, [""; 0]);
            check(&flat(&turned), &triangles);
            // Tiny and huge polygons, tilted, near the origin and far from it.
            for (size, place) in
                [(1.0, [0.0; 3]), (1.0, [4e5, 5e6, 80.0]), (1e-300, [0.0; 3]), (1e300, [0.0; 3])]
            {
                let corners = put(&turned, size, place);
                let (triangles, notes) = cut::<f64>(&corners);
                assert_eq!(notes, [""; 0], "{corners:?}");
                let near: Vec<Point> =
                    corners.iter().map(|p| [0, 1, 2].map(|k| (p[k] - place[k]) / size)).collect();
                check(&near, &triangles);
            }
        }
    }
}

#[test]
fn a_polygon_that_its_first_corner_sees_is_a_fan() {
    let fan = |count: usize| (2..count).map(|i| [0, i - 1, i]).collect::<Vec<_>>();
    let circle: Vec<_> =
        (0..100).map(|i| f64::from(i) * 0.0628).map(|a| [a.cos(), a.sin()]).collect();
    // A dart that starts at its tip or at its inner corner, a square with corners on its edges, and
    // a line.
    let mut middle = DART;
    middle.rotate_left(2);
    let square: Vec<_> = (0..8)
        .map(|i| {
            [
                [0.0, 1.0, 2.0, 2.0, 2.0, 1.0, 0.0, 0.0][i],
                [0.0, 0.0, 0.0, 1.0, 2.0, 2.0, 2.0, 1.0][i],
            ]
        })
        .collect();
    let line: Vec<_> = (0..6).map(|i| [f64::from(i % 4), 0.0]).collect();
    for polygon in [&circle[..], &DART, &middle, &square, &line] {
        for corners in [flat(polygon), put(polygon, 1.0, [0.0; 3])] {
            assert_eq!(cut::<f64>(&corners), (fan(polygon.len()), vec![]), "{corners:?}");
        }
    }
    // A quad that is not planar also keeps its fan.
    let bent = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.3], [1.0, 1.0, 0.0], [0.0, 1.0, 0.3]];
    assert_eq!(cut::<f32>(&bent), (fan(4), vec![]));
}

#[test]
fn concave_polygons_that_are_not_flat_are_cut_in_their_best_plane() {
    for turned in turns(&STRAIGHT) {
        let heights = [0.0, 0.05, -0.03, 0.04, 0.01];
        let bent: Vec<Point> =
            turned.iter().zip(heights.iter().cycle()).map(|(&[x, y], &z)| [x, y, z]).collect();
        let (triangles, notes) = cut::<f64>(&bent);
        assert_eq!(notes, [""; 0]);
        check(&flat(&turned), &triangles);
    }
}

#[test]
fn polygons_that_cross_themselves_are_fans_and_counted() {
    let said = "concave faces that cross themselves or have more than 16384 corners, filled as fans: 1 (in line ";
    let star: Vec<_> = (0..5).map(|i| f64::from(i) * 2.513).map(|a| [a.cos(), a.sin()]).collect();
    let bow = [[0.0, 0.0], [1.0, 1.0], [1.0, 0.0], [0.0, 1.0]];
    for polygon in [&star[..], &bow] {
        let (triangles, notes) = cut::<f32>(&flat(polygon));
        assert_eq!(triangles[0], [0, 1, 2]);
        assert_eq!(notes, [format!("{said}{})", polygon.len() + 1)]);
    }
    // Polygons this large are not cut, so the time stays linear in the size of the file.
    let comb: Vec<_> =
        (0..20_000).map(|i| [f64::from(i), f64::from(i % 2)]).chain([[1.0, -9.0]]).collect();
    let (triangles, notes) = cut::<f32>(&flat(&comb));
    assert_eq!((triangles.len(), notes.len()), (19_999, 1));
}

/// Cuts stars with many corners at random distances from the centre.
#[test]
fn stars_are_covered() {
    let mut state = 1_u64;
    let mut random = || {
        state =
            state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 40) as f64 / (1 << 24) as f64
    };
    for round in 0..300 {
        let count = 5 + round % 40;
        let corner = |i: usize, random: f64| {
            let (angle, far) = (i as f64 / count as f64 * std::f64::consts::TAU, 0.1 + random);
            [angle.cos() * far, angle.sin() * far]
        };
        let star: Vec<[f64; 2]> = (0..count).map(|i| corner(i, random())).collect();
        let (triangles, notes) = cut::<f64>(&put(&star, 1.0, [0.0; 3]));
        assert_eq!(notes, [""; 0]);
        check(&put(&star, 1.0, [0.0; 3]), &triangles);
    }
}
