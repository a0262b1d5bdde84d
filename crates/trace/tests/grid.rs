//! Tests that classifying a grid of points returns the same results as classifying each point
//! alone.

use intertri_trace::intertri::{Triangle64, TriangleOf};
use intertri_trace::{BvhScalar, Containment, Solid};

type Mesh = Vec<[[f64; 3]; 3]>;

/// Returns a prism over a convex polygon in the xy-plane. If `is_cracked` is true, the upper edges
/// are split, and the gaps are filled with needles, some of which have zero area.
fn prism(corners: &[[f64; 2]], [low, high]: [f64; 2], is_cracked: bool) -> Mesh {
    let at = |i: usize, z: f64| [corners[i][0], corners[i][1], z];
    let count = corners.len();
    let mut mesh = Mesh::new();
    for i in 2..count {
        mesh.push([at(0, low), at(i, low), at(i - 1, low)]);
        mesh.push([at(0, high), at(i - 1, high), at(i, high)]);
    }
    for (i, j) in (0..count).map(|i| (i, (i + 1) % count)) {
        let [a, b, c, d] = [at(i, low), at(j, low), at(j, high), at(i, high)];
        if is_cracked {
            // Split the upper edge near its midpoint, and fill the gap with a needle.
            let mut m = [0, 1, 2].map(|k| 0.5 * c[k] + 0.5 * d[k]);
            m[0] += 1e-9;
            mesh.extend([[a, b, c], [a, c, m], [a, m, d], [m, c, d]]);
        } else {
            mesh.extend([[a, b, c], [a, c, d]]);
        }
    }
    mesh
}

/// Returns a sphere of radius 4 around the point `(centre, 4, 4)`, made of `rings` rings of
/// triangles.
fn globe(rings: usize, centre: f64) -> Mesh {
    let corner = |ring: usize, i: usize| {
        let (a, b) = (ring as f64 / rings as f64, (i % rings) as f64 / rings as f64);
        let (a, b) = (a * std::f64::consts::PI, b * std::f64::consts::TAU);
        let r = if ring == 0 || ring == rings { 0.0 } else { a.sin() };
        [centre + 4.0 * r * b.cos(), 4.0 + 4.0 * a.cos(), 4.0 + 4.0 * r * b.sin()]
    };
    let squares = (0..rings * rings).map(|i| (i / rings, i % rings));
    let halves = squares.flat_map(|(ring, i)| {
        let [a, b] = [corner(ring, i), corner(ring, i + 1)];
        let [c, d] = [corner(ring + 1, i), corner(ring + 1, i + 1)];
        [[a, b, c], [d, c, b]]
    });
    halves.collect()
}

/// Returns the mesh with the three coordinates of each corner cyclically shifted by `by` places.
fn rolled(mesh: &Mesh, by: usize) -> Mesh {
    mesh.iter().map(|t| t.map(|p| [0, 1, 2].map(|k| p[(k + by) % 3]))).collect()
}

/// Compares the classification of a grid with that of each point alone. Returns the numbers of
/// points inside, outside, and on the surface.
fn check<S: BvhScalar>(solid: &Solid<S>, axes: [&[S]; 3]) -> [usize; 3] {
    let [x, y, z] = axes;
    let all = solid.classify_grid(axes);
    let mut counts = [0; 3];
    for (i, found) in all.iter().enumerate() {
        let plane = i / z.len();
        let point = [x[plane / y.len()], y[plane % y.len()], z[i % z.len()]];
        assert_eq!(*found, solid.classify(point), "{point:?}");
        counts[match found {
            Containment::Inside(_) => 0,
            Containment::Outside => 1,
            Containment::Surface => 2,
        }] += 1;
    }
    assert_eq!(counts.iter().sum::<usize>(), x.len() * y.len() * z.len());
    counts
}

/// Checks a mesh, moved by `offset`, on four grids: one with steps of 1/2, one with steps of 1/3,
/// one with decreasing steps, and one whose coordinates are those of the corners and slightly
/// larger values. Returns the total numbers of points inside, outside, and on the surface.
fn check_all<S: BvhScalar>(mesh: &Mesh, offset: [f64; 3]) -> [usize; 3] {
    let corner = |p: [f64; 3]| [0, 1, 2].map(|k| S::nearest(p[k] + offset[k]));
    let triangles: Vec<TriangleOf<S>> = mesh.iter().map(|t| TriangleOf(t.map(corner))).collect();
    let solid = Solid::new(&triangles).unwrap();
    let axis = |k: usize, at: &dyn Fn(f64) -> f64| -> Vec<S> {
        (0..19).map(|i| S::nearest(offset[k] + at(f64::from(i)))).collect()
    };
    let mut axes = [
        [0, 1, 2].map(|k| axis(k, &|i| 0.5 * i - 0.5)),
        [0, 1, 2].map(|k| axis(k, &|i| i / 3.0 + 0.1)),
        [0, 1, 2].map(|k| axis(k, &|i| 8.0 - 9.0 / (i + 1.0))),
    ]
    .to_vec();
    axes.push([0, 1, 2].map(|k| {
        let numbers = triangles.iter().flat_map(|t| t.0).map(|corner| corner[k]);
        let mut numbers: Vec<S> = numbers.step_by(triangles.len() / 4 + 1).collect();
        let next = numbers.clone().into_iter().map(|x| {
            let x: f64 = x.into();
            S::nearest(x + x.abs() * if size_of::<S>() == 4 { 1e-7 } else { 2e-16 })
        });
        numbers.extend(next);
        numbers.sort_unstable_by_key(|x| x.key());
        numbers.sort_unstable_by(|a, b| a.partial_cmp(b).unwrap());
        numbers
    }));
    let mut counts = [0; 3];
    for [x, y, z] in &axes {
        let found = check(&solid, [x, y, z]);
        (0..3).for_each(|k| counts[k] += found[k]);
    }
    counts
}

#[test]
fn grids_are_their_points() {
    let square = [[1.0, 1.0], [5.0, 1.0], [5.0, 5.0], [1.0, 5.0]];
    let slanted = [[1.0, 0.0], [7.0, 6.0], [6.0, 7.0], [0.0, 1.0]];
    let mut turned = prism(&square, [1.5, 6.5], false);
    for t in &mut turned {
        t.swap(0, 1);
    }
    let mut two = globe(12, 4.0);
    two.extend(globe(9, 6.0));
    let meshes = [
        prism(&square, [1.5, 6.5], false),
        turned,
        prism(&slanted, [1.0, 6.0], false),
        prism(&slanted, [1.0, 6.0], true),
        two,
        globe(40, 4.0),
        Mesh::new(),
    ];
    let mut counts = [0; 3];
    for mesh in meshes.iter().flat_map(|mesh| [0, 1, 2].map(|by| rolled(mesh, by))) {
        for found in [
            check_all::<f32>(&mesh, [0.0; 3]),
            check_all::<f32>(&mesh, [1024.0, -77.0, 4096.5]),
            check_all::<f64>(&mesh, [500_000.3, 4_600_000.1, 120.0]),
            check_all::<f64>(&mesh, [0.0; 3]),
        ] {
            (0..3).for_each(|k| counts[k] += found[k]);
        }
    }
    assert!(counts.iter().all(|&count| count > 10_000), "{counts:?}");
}

/// Repeats the comparison for grids with descending or non-finite coordinates, for empty grids, and
/// for an open mesh.
#[test]
fn other_grids_are_their_points() {
    let square = [[1.0, 1.0], [5.0, 1.0], [5.0, 5.0], [1.0, 5.0]];
    let mut mesh: Vec<_> = prism(&square, [1.0, 5.0], false).into_iter().map(Triangle64).collect();
    let solid = Solid::new(&mesh).unwrap();
    let up: Vec<f64> = (0..13).map(|i| 0.5 * f64::from(i)).collect();
    let down: Vec<f64> = up.iter().rev().copied().collect();
    let bad = [f64::NEG_INFINITY, 1.0, 2.0, f64::NAN];
    for [x, y, z] in [[&up[..], &up, &down], [&down, &up, &up], [&up, &bad, &up], [&up, &up, &bad]]
    {
        check(&solid, [x, y, z]);
    }
    assert_eq!(check(&solid, [&[], &up, &up]), [0; 3]);
    assert_eq!(check(&solid, [&up, &up, &[]]), [0; 3]);
    assert!(check(&solid, [&[1.0], &[2.0], &[2.0, 2.0]])[2] == 2);

    mesh.truncate(mesh.len() - 2);
    let open = Solid::from_soup(&mesh).unwrap();
    assert!(open.open_edges() > 0 && check(&open, [&up, &up, &up])[0] > 100);
}

/// Tests coordinates so small or large that their products underflow or overflow.
#[test]
fn grids_of_extreme_sizes_are_their_points() {
    let slanted = [[1.0, 0.0], [7.0, 6.0], [6.0, 7.0], [0.0, 1.0]];
    for scale in [1e-200, 1e-120, 1e120, 1e200] {
        let scaled = |t: [[f64; 3]; 3]| Triangle64(t.map(|p| p.map(|x| scale * x)));
        let mesh: Vec<_> = prism(&slanted, [1.0, 6.0], false).into_iter().map(scaled).collect();
        let axis: Vec<f64> = (0..15).map(|i| 0.5 * f64::from(i) * scale).collect();
        let counts = check(&Solid::new(&mesh).unwrap(), [&axis, &axis, &axis]);
        assert!(counts.iter().all(|&count| count > 50), "{scale}: {counts:?}");
    }
}
