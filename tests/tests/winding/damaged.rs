//! Generates meshes with typical damage: boxes and globes with holes, flipped and duplicated faces,
//! cracks, fins and T-junctions.

use intertri::Triangle64;
use intertri_lab::rng::Rng;

/// Rounds a number to a multiple of 1/1024, so that differences between such numbers have few
/// digits.
fn on_grid(x: f64) -> f64 {
    (x * 1024.0).round() / 1024.0
}

/// Returns a box from -1/2 to 1/2 with `cells`×`cells` squares per side.
fn cube(cells: usize) -> Vec<Triangle64> {
    let mut faces = Vec::new();
    for side in 0..6 {
        let (axis, up) = (side % 3, side < 3);
        let at = |i: usize, j: usize| {
            let mut corner = [0.0; 3];
            corner[axis] = if up { 0.5 } else { -0.5 };
            corner[(axis + 1) % 3] = on_grid(i as f64 / cells as f64 - 0.5);
            corner[(axis + 2) % 3] = on_grid(j as f64 / cells as f64 - 0.5);
            corner
        };
        for (i, j) in (0..cells * cells).map(|k| (k / cells, k % cells)) {
            let [a, b, c, d] = [at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)];
            let halves = [[a, b, c], [a, c, d]];
            faces
                .extend(halves.map(|[a, b, c]| Triangle64(if up { [a, b, c] } else { [a, c, b] })));
        }
    }
    faces
}

/// Returns a globe made of `rings` rings of triangles.
fn globe(rings: usize) -> Vec<Triangle64> {
    let corner = |ring: usize, i: usize| {
        let (a, b) = (ring as f64 / rings as f64, (i % (2 * rings)) as f64 / (2 * rings) as f64);
        let (a, b) = (a * std::f64::consts::PI, b * std::f64::consts::TAU);
        let r = if ring == 0 || ring == rings { 0.0 } else { 0.5 * a.sin() };
        [r * b.cos(), 0.5 * a.cos(), r * b.sin()].map(on_grid)
    };
    let squares = (0..2 * rings * rings).map(|k| (k / (2 * rings), k % (2 * rings)));
    let halves = |(ring, i)| {
        let [a, b] = [corner(ring, i), corner(ring, i + 1)];
        let [c, d] = [corner(ring + 1, i), corner(ring + 1, i + 1)];
        [Triangle64([a, b, c]), Triangle64([d, c, b])]
    };
    squares
        .flat_map(halves)
        .filter(|t| t.0[0] != t.0[1] && t.0[1] != t.0[2] && t.0[2] != t.0[0])
        .collect()
}

fn middle(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [0, 1, 2].map(|k| 0.5 * (a[k] + b[k]))
}

/// The ways to damage a mesh.
const DAMAGES: [fn(&mut Vec<Triangle64>, &mut Rng); 8] = [
    // A hole.
    |mesh, rng| {
        let at = rng.pick(mesh).0[0];
        mesh.retain(|triangle| !triangle.0.contains(&at));
    },
    // Some missing faces.
    |mesh, rng| mesh.retain(|_| rng.unit() > 0.1),
    // A missing lid.
    |mesh, _| mesh.retain(|t| t.0.iter().any(|corner| corner[1] < 0.3)),
    // Flipped faces.
    |mesh, rng| {
        for triangle in mesh.iter_mut().filter(|_| rng.unit() < 0.2) {
            triangle.0.swap(0, 1);
        }
    },
    // Duplicated faces, some of them flipped.
    |mesh, rng| {
        for i in 0..mesh.len() {
            let mut triangle = mesh[i];
            triangle.0.swap(0, rng.below(2));
            if rng.one_in(5) {
                mesh.push(triangle);
            }
        }
    },
    // Cracks: a corner is moved in some faces but not in their neighbours.
    |mesh, rng| {
        for triangle in mesh.iter_mut() {
            triangle.0[0][1] += on_grid(0.02) * rng.pick(&[0.0, 0.0, 0.0, 0.0, 1.0, -1.0]);
        }
    },
    // Fins.
    |mesh, rng| {
        for _ in 0..4 {
            let [a, b, _] = rng.pick(mesh).0;
            mesh.push(Triangle64([b, a, a.map(|x| on_grid(1.4 * x + 0.05))]));
        }
    },
    // T-junctions: some faces are cut in two, but their neighbours are not. Degenerate triangles
    // close some of the gaps.
    |mesh, rng| {
        let count = mesh.len();
        for i in (0..count).filter(|i| i % 7 == 0) {
            let [a, b, c] = mesh[i].0;
            let m = middle(a, b);
            mesh[i] = Triangle64([a, m, c]);
            mesh.push(Triangle64([m, b, c]));
            if rng.unit() < 0.4 {
                mesh.push(Triangle64([a, b, m]));
            }
        }
    },
];

/// Generates the mesh with the given number and damages it in one to three ways. Coordinates are
/// multiples of 1/8192 between -1 and 1.
pub(super) fn mesh(number: usize, rng: &mut Rng) -> Vec<Triangle64> {
    let mut mesh =
        if number.is_multiple_of(2) { cube(1 + number / 2 % 5) } else { globe(4 + number / 2 % 5) };
    DAMAGES[number / 2 % 8](&mut mesh, rng);
    for _ in 0..number % 3 {
        if mesh.len() > 8 {
            rng.pick(&DAMAGES)(&mut mesh, rng);
        }
    }
    mesh
}
