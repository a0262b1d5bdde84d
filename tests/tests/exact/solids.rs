//! Generates closed meshes. The corners are snapped to a grid, so that the differences between them
//! are exact in f32 unless the mesh is scaled to an extreme size.

use intertri::{Triangle, TriangleOf};
use intertri_lab::meshes::Mesh;
use intertri_lab::rng::Rng;

/// A mesh, with its size and centre, in which every edge is traversed equally often in both
/// directions.
pub(crate) struct Closed {
    pub(crate) name: &'static str,
    pub(crate) triangles: Vec<Triangle>,
    pub(crate) scale: f64,
    pub(crate) centre: [f64; 3],
}

/// A centre far from the coordinate origin.
const AFAR: [f64; 3] = [148_376.0, 1_234.0, -223_423.0];

/// Generates all meshes. A larger `finer` makes the meshes finer.
pub(crate) fn meshes(finer: usize) -> Vec<Closed> {
    let mut rng = Rng::new(7);
    let sphere = Mesh::icosphere(1 + finer as u32);
    let torus = Mesh::torus(12 * finer, 6 * finer);
    let (knot, hull, lattice) =
        (knot(40 * finer, 5 * finer), hull(30 * finer, &mut rng), lattice(3));
    let mut all = vec![];
    let mut add = |name, mesh: &Mesh, scale, centre| {
        all.push(Closed { name, triangles: snapped(mesh, scale, centre), scale, centre });
    };
    for (name, scale, centre) in [
        ("sphere", 1.0, [0.0; 3]),
        ("sphere afar", 1.0, AFAR),
        ("vast sphere", 1e18, [0.0; 3]),
        ("tiny sphere", 1e-18, [0.0; 3]),
        ("subnormal sphere", 1e-39, [0.0; 3]),
    ] {
        add(name, &sphere, scale, centre);
    }
    for (name, mesh) in [("torus", &torus), ("knot", &knot), ("hull", &hull), ("lattice", &lattice)]
    {
        add(name, mesh, 1.0, [0.0; 3]);
    }
    for (name, mesh) in [("knot afar", &knot), ("hull afar", &hull), ("lattice afar", &lattice)] {
        add(name, mesh, 100.0, AFAR);
    }
    add("vast knot", &knot, 1e18, [0.0; 3]);
    add("tiny hull", &hull, 1e-18, [0.0; 3]);

    let of = |name: &str| all.iter().find(|mesh| mesh.name == name).unwrap().triangles.clone();
    let turned = |TriangleOf([a, b, c]): Triangle| Triangle([a, c, b]);
    let twice = [of("sphere"), of("sphere")].concat();
    let inverted = of("torus").into_iter().map(turned).collect();
    let more = [
        ("twice", twice),
        ("inverted", inverted),
        ("soiled sphere", soiled(of("sphere"), &mut rng)),
        ("soiled torus", soiled(of("torus"), &mut rng)),
        ("soiled hull", soiled(of("hull"), &mut rng)),
        ("soiled lattice", soiled(of("lattice"), &mut rng)),
        // A sphere inside another. The inner sphere is turned inside out, so that the mesh is a
        // hollow shell.
        ("shell", [of("sphere"), halved(of("sphere")).into_iter().map(turned).collect()].concat()),
    ];
    let plain = |(name, triangles)| Closed { name, triangles, scale: 1.0, centre: [0.0; 3] };
    all.extend(more.map(plain));
    let stuck = Closed { name: "stuck", triangles: stuck(), scale: 2.0, centre: [0.0; 3] };
    all.push(stuck);
    all
}

/// Snaps the corners to a grid.
fn snapped(mesh: &Mesh, scale: f64, centre: [f64; 3]) -> Vec<Triangle> {
    let on_grid = |p: [f64; 3]| p.map(|x| (x * 4096.0).round() / 4096.0);
    let moved = |p| [0, 1, 2].map(|k| f64::from((on_grid(p)[k] * scale + centre[k]) as f32));
    mesh.clone().map(moved).triangles()
}

fn halved(mesh: Vec<Triangle>) -> Vec<Triangle> {
    mesh.into_iter()
        .map(|TriangleOf(corners)| Triangle(corners.map(|c| c.map(|x| 0.5 * x))))
        .collect()
}

/// Returns two cubes that share an edge, and a third that shares a face with the first.
fn stuck() -> Vec<Triangle> {
    let cube = |by: [f64; 3]| Mesh::cube(2).map(|p| [0, 1, 2].map(|k| p[k] + by[k])).triangles();
    [[0.0; 3], [2.0, 2.0, 0.0], [0.0, 0.0, 2.0]].map(cube).concat()
}

/// Adds triangles that cancel each other, are duplicates, or are degenerate.
fn soiled(mut mesh: Vec<Triangle>, rng: &mut Rng) -> Vec<Triangle> {
    for _ in 0..mesh.len() / 4 {
        let TriangleOf([a, b, c]) = rng.pick(&mesh);
        mesh.extend([Triangle([a, b, c]), Triangle([a, c, b])]);
        mesh.extend([Triangle([a, a, b]), Triangle([c, c, c])]);
    }
    mesh
}

/// Returns a tube around a trefoil knot of radius 1.
fn knot(around: usize, across: usize) -> Mesh {
    let at = |i: usize| {
        let s = std::f64::consts::TAU * i as f64 / around as f64;
        let r = (2.0 + (3.0 * s).cos()) / 3.5;
        [r * (2.0 * s).cos(), r * (2.0 * s).sin(), (3.0 * s).sin() / 3.5]
    };
    let mut vertices = vec![];
    for i in 0..around {
        // Two directions across the tube: one points away from the central axis, and the other is
        // perpendicular to it and to the tube.
        let (centre, next) = (at(i), at(i + 1));
        let tangent = unit(minus(next, centre));
        let aside = unit(cross(tangent, [0.0, 0.0, 1.0]));
        let up = cross(aside, tangent);
        for j in 0..across {
            let angle = std::f64::consts::TAU * j as f64 / across as f64;
            let (x, y) = (0.1 * angle.cos(), 0.1 * angle.sin());
            vertices.push([0, 1, 2].map(|k| centre[k] + x * aside[k] + y * up[k]));
        }
    }
    let vertex = |i: usize, j: usize| i % around * across + j % across;
    let quads = (0..around * across).map(|q| (q / across, q % across));
    let faces = quads.flat_map(|(i, j)| {
        let [a, b, c, d] = [vertex(i, j), vertex(i, j + 1), vertex(i + 1, j + 1), vertex(i + 1, j)];
        [[a, c, b], [a, d, c]]
    });
    Mesh { faces: faces.collect(), vertices }
}

/// Generates the convex hull of random integer points, which are added one by one. Some coplanar
/// points are skipped, and some faces may be degenerate, but the mesh is always closed.
fn hull(points: usize, rng: &mut Rng) -> Mesh {
    let point = |rng: &mut Rng| {
        let way = rng.direction();
        way.map(|x| (16.0 * x).round())
    };
    let mut vertices =
        vec![[-9.0, -9.0, -9.0], [9.0, 9.0, -9.0], [9.0, -9.0, 9.0], [-9.0, 9.0, 9.0]];
    let mut faces = vec![[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]];
    for _ in 0..points {
        let new = point(rng);
        let sees = |&[a, b, c]: &[usize; 3], vertices: &[[f64; 3]]| {
            let [a, b, c] = [a, b, c].map(|i| vertices[i]);
            dot(cross(minus(b, a), minus(c, a)), minus(new, a)) > 0.0
        };
        let (seen, hidden): (Vec<_>, Vec<_>) =
            faces.iter().copied().partition(|face| sees(face, &vertices));
        if seen.is_empty() {
            continue;
        }
        let edges = || seen.iter().flat_map(|&[a, b, c]| [(a, b), (b, c), (c, a)]);
        let horizon = edges().filter(|&(a, b)| edges().all(|edge| edge != (b, a)));
        faces = horizon.map(|(a, b)| [a, b, vertices.len()]).chain(hidden).collect();
        vertices.push(new);
    }
    Mesh { vertices: vertices.into_iter().map(|p| p.map(|x| x / 16.0)).collect(), faces }
}

/// Generates cubes that touch only along edges and at corners, like the squares of one colour on a
/// chessboard.
fn lattice(side: i32) -> Mesh {
    let mut all = Mesh { vertices: vec![], faces: vec![] };
    let places = (0..side.pow(3)).map(|i| [i % side, i / side % side, i / side / side]);
    for place in places.filter(|place| place.iter().sum::<i32>() % 2 == 0) {
        let cube = Mesh::cube(1);
        let first = all.vertices.len();
        let at = |p: [f64; 3]| [0, 1, 2].map(|k| 0.25 * p[k] + 0.5 * f64::from(place[k]) - 0.5);
        all.vertices.extend(cube.vertices.into_iter().map(at));
        all.faces.extend(cube.faces.into_iter().map(|face| face.map(|i| first + i)));
    }
    all
}

fn minus(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [0, 1, 2].map(|k| a[k] - b[k])
}

fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

fn cross(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

fn unit(a: [f64; 3]) -> [f64; 3] {
    let length = dot(a, a).sqrt();
    a.map(|x| x / length)
}
