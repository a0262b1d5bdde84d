//! Generates closed meshes for the tests of the `fixed` mode: a sphere and an octahedron.

use std::collections::HashMap;

/// Returns a unit sphere: an icosahedron whose triangles are repeatedly divided into four. Corners
/// are counter-clockwise as seen from outside.
pub(crate) fn icosphere(levels: u32) -> Vec<[[f32; 3]; 3]> {
    // The twelve corners (0, 1, p), (1, p, 0), (p, 0, 1) with all signs; p is the golden ratio.
    let p = f64::midpoint(1.0, 5.0_f64.sqrt());
    let mut corners = Vec::new();
    for (s, t) in [(1.0, 1.0), (1.0, -1.0), (-1.0, 1.0), (-1.0, -1.0)] {
        corners.extend([[0.0, s, t * p], [s, t * p, 0.0], [t * p, 0.0, s]]);
    }
    let near = |a: [f64; 3], b: [f64; 3]| (0..3).map(|i| (a[i] - b[i]).powi(2)).sum::<f64>() < 4.1;

    // Any three corners that are pairwise neighbours form a face.
    let mut faces = Vec::new();
    for i in 0..12 {
        for j in i + 1..12 {
            for k in j + 1..12 {
                let [a, b, c] = [corners[i], corners[j], corners[k]];
                if near(a, b) && near(b, c) && near(c, a) {
                    let volume = (0..3).map(|x| {
                        let (y, z) = ((x + 1) % 3, (x + 2) % 3);
                        a[x] * (b[y] * c[z] - b[z] * c[y])
                    });
                    faces.push(if volume.sum::<f64>() > 0.0 { [a, b, c] } else { [a, c, b] });
                }
            }
        }
    }
    assert_eq!(faces.len(), 20);
    for _ in 0..levels {
        faces = faces
            .into_iter()
            .flat_map(|[a, b, c]| {
                // The midpoint does not depend on the order of the corners, so neighbouring
                // triangles share it.
                let middle =
                    |a: [f64; 3], b: [f64; 3]| [0, 1, 2].map(|i| f64::midpoint(a[i], b[i]));
                let (ab, bc, ca) = (middle(a, b), middle(b, c), middle(c, a));
                [[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]]
            })
            .collect();
    }
    faces
        .into_iter()
        .map(|face| {
            face.map(|p| {
                let length = p.iter().map(|x| x * x).sum::<f64>().sqrt();
                p.map(|x| (x / length) as f32)
            })
        })
        .collect()
}

/// Returns the octahedron `|x| + |y| + |z| <= cells * cell` in integers. Each face is divided into
/// `cells^2` coplanar triangles, whose corners are counter-clockwise as seen from outside.
pub(crate) fn octahedron(cells: i32, cell: i32) -> Vec<[[i32; 3]; 3]> {
    let mut faces = Vec::new();
    for signs in 0..8 {
        let sign = [0, 1, 2].map(|axis| if signs >> axis & 1 == 0 { cell } else { -cell });
        let outward = sign.iter().filter(|&&s| s < 0).count() % 2 == 0;
        let point = |i: i32, j: i32| [i * sign[0], j * sign[1], (cells - i - j) * sign[2]];
        let mut push = |[a, b, c]: [[i32; 3]; 3]| {
            faces.push(if outward { [a, b, c] } else { [a, c, b] });
        };
        for i in 0..cells {
            for j in 0..cells - i {
                push([point(i + 1, j), point(i, j + 1), point(i, j)]);
                if i + j + 1 < cells {
                    push([point(i + 1, j + 1), point(i, j + 1), point(i + 1, j)]);
                }
            }
        }
    }
    faces
}

/// Returns whether every edge is traversed equally often in both directions.
pub(crate) fn is_closed(mesh: &[[[i32; 3]; 3]]) -> bool {
    let mut edges = HashMap::new();
    for [a, b, c] in mesh {
        for (from, to) in [(a, b), (b, c), (c, a)] {
            *edges.entry((from, to)).or_insert(0) += 1;
            *edges.entry((to, from)).or_insert(0) -= 1;
        }
    }
    edges.into_values().all(|count| count == 0)
}
