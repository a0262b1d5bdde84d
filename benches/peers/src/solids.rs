//! Generates closed meshes: a cube, an icosahedron and a torus.

use std::f64::consts::TAU;

use intertri_scene::Mesh;

/// The numbers of points around the torus and around its tube. The number of triangles is twice the
/// product of these numbers.
const TORUS: [u32; 2] = [96, 48];

/// Creates a mesh by its name.
pub fn solid(name: &str) -> Option<Mesh> {
    match name {
        "cube" => Some(cube()),
        "icosahedron" => Some(icosahedron()),
        "torus" => Some(torus()),
        _ => None,
    }
}

/// Returns a cube from -1 to 1 along each axis: six squares of two triangles each.
fn cube() -> Mesh {
    let positions = (0..8).map(|i| [0, 1, 2].map(|axis| (2 * (i >> axis & 1) - 1) as f32));
    // The indices of a face's corners share one bit, and are listed in order around the square.
    let square = |face: u32| {
        let (axis, end) = (face / 2, face % 2);
        let (u, v) = (1 << ((axis + 1) % 3), 1 << ((axis + 2) % 3));
        let first = end << axis;
        [[first, first + u, first + u + v], [first, first + u + v, first + v]]
    };
    let triangles = (0..6).flat_map(square).collect();
    Mesh { positions: positions.collect(), triangles, ..Mesh::default() }
}

/// Returns an icosahedron, whose vertices are the corners of three golden rectangles. Each face
/// consists of three vertices at a distance of 2 from each other.
fn icosahedron() -> Mesh {
    let golden = f32::midpoint(1.0, 5.0_f32.sqrt());
    let corner = |i: usize| {
        let (axis, sign) = (i / 4, |bit: usize| if i >> bit & 1 == 0 { 1.0 } else { -1.0 });
        let mut p = [0.0; 3];
        (p[axis], p[(axis + 1) % 3]) = (sign(0), sign(1) * golden);
        p
    };
    let positions: Vec<[f32; 3]> = (0..12).map(corner).collect();
    let near = |a: u32, b: u32| {
        let [a, b] = [a, b].map(|i| positions[i as usize]);
        [0, 1, 2].map(|k| (a[k] - b[k]).powi(2)).iter().sum::<f32>() < 4.1
    };
    let mut triangles = Vec::new();
    for a in 0..12 {
        for b in a + 1..12 {
            let third = (b + 1..12).filter(|&c| near(a, b) && near(b, c) && near(c, a));
            triangles.extend(third.map(|c| [a, b, c]));
        }
    }
    Mesh { positions, triangles, ..Mesh::default() }
}

/// Returns a torus: a tube of radius 0.4 around a circle of radius 1.
fn torus() -> Mesh {
    let [m, n] = TORUS;
    let point = |i: u32, j: u32| {
        let [u, v] = [(i, m), (j, n)].map(|(i, of)| TAU * f64::from(i) / f64::from(of));
        let r = 1.0 + 0.4 * v.cos();
        [r * u.cos(), r * u.sin(), 0.4 * v.sin()].map(|x| x as f32)
    };
    let mut mesh = Mesh::default();
    for i in 0..m {
        for j in 0..n {
            mesh.positions.push(point(i, j));
            let at = |i, j| i % m * n + j % n;
            let [a, b, c, d] = [at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)];
            mesh.triangles.extend([[a, b, c], [a, c, d]]);
        }
    }
    mesh
}
