//! Small closed meshes. Their vertices are computed with only `+ - * /` and square roots, so they
//! have the same bits on every machine. Neighbouring faces have bitwise equal vertices.

use std::collections::BTreeMap;

use intertri::Triangle;

/// A mesh: a list of vertices, and faces given by indices into that list.
#[derive(Clone, Debug, PartialEq)]
pub struct Mesh {
    /// The vertices, in f64 so that they can be moved and scaled before they are rounded.
    pub vertices: Vec<[f64; 3]>,
    /// Three vertices per face, counter-clockwise as seen from outside.
    pub faces: Vec<[usize; 3]>,
}

impl Mesh {
    /// Creates a sphere of radius 1: an icosahedron with every face split into four `splits` times,
    /// for a total of `20 * 4^splits` faces.
    pub fn icosphere(splits: u32) -> Self {
        let golden = f64::midpoint(1.0, 5.0_f64.sqrt());
        let (s, g) = (1.0, golden);
        let vertices = [
            [-s, g, 0.0],
            [s, g, 0.0],
            [-s, -g, 0.0],
            [s, -g, 0.0],
            [0.0, -s, g],
            [0.0, s, g],
            [0.0, -s, -g],
            [0.0, s, -g],
            [g, 0.0, -s],
            [g, 0.0, s],
            [-g, 0.0, -s],
            [-g, 0.0, s],
        ];
        let faces = [
            [0, 11, 5],
            [0, 5, 1],
            [0, 1, 7],
            [0, 7, 10],
            [0, 10, 11],
            [1, 5, 9],
            [5, 11, 4],
            [11, 10, 2],
            [10, 7, 6],
            [7, 1, 8],
            [3, 9, 4],
            [3, 4, 2],
            [3, 2, 6],
            [3, 6, 8],
            [3, 8, 9],
            [4, 9, 5],
            [2, 4, 11],
            [6, 2, 10],
            [8, 6, 7],
            [9, 8, 1],
        ];
        let mut mesh = Self { vertices: vertices.map(unit).to_vec(), faces: faces.to_vec() };
        for _ in 0..splits {
            mesh.split();
        }
        mesh
    }

    /// Splits each face into four and moves the new vertices out to the sphere.
    fn split(&mut self) {
        let mut middles = BTreeMap::new();
        let vertices = &mut self.vertices;
        let mut middle = |a: usize, b: usize| {
            *middles.entry((a.min(b), a.max(b))).or_insert_with(|| {
                let (p, q) = (vertices[a], vertices[b]);
                vertices.push(unit([p[0] + q[0], p[1] + q[1], p[2] + q[2]]));
                vertices.len() - 1
            })
        };
        let mut faces = Vec::with_capacity(4 * self.faces.len());
        for &[a, b, c] in &self.faces {
            let (ab, bc, ca) = (middle(a, b), middle(b, c), middle(c, a));
            faces.extend([[a, ab, ca], [b, bc, ab], [c, ca, bc], [ab, bc, ca]]);
        }
        self.faces = faces;
    }

    /// Creates a torus around the z axis with radii 0.7 and 0.3, made of `around * across` quads
    /// with two faces each. Counts below 3 are treated as 3.
    pub fn torus(around: usize, across: usize) -> Self {
        let (around, across) = (around.max(3), across.max(3));
        let mut vertices = Vec::with_capacity(around * across);
        let mut faces = Vec::with_capacity(2 * around * across);
        for i in 0..around {
            let [cx, cy] = circle(i, around);
            for j in 0..across {
                let [dx, dz] = circle(j, across);
                let radius = 0.7 + 0.3 * dx;
                vertices.push([radius * cx, radius * cy, 0.3 * dz]);
                let at = |i: usize, j: usize| (i % around) * across + j % across;
                let (a, b) = (at(i, j), at(i + 1, j));
                let (c, d) = (at(i + 1, j + 1), at(i, j + 1));
                faces.extend([[a, b, c], [a, c, d]]);
            }
        }
        Self { vertices, faces }
    }

    /// Creates a cube from `-n` to `n`, with vertices at integer points one unit apart. It has
    /// `48 n^2` faces, whose diagonals run both ways.
    pub fn cube(n: usize) -> Self {
        let n = n.max(1) as i32;
        let mut mesh = Self { vertices: Vec::new(), faces: Vec::new() };
        let mut known = BTreeMap::new();
        for axis in 0..3 {
            for side in [-n, n] {
                for u in -n..n {
                    for v in -n..n {
                        let [a, b, c, d] =
                            [(u, v), (u + 1, v), (u + 1, v + 1), (u, v + 1)].map(|(u, v)| {
                                let mut p = [side; 3];
                                p[(axis + 1) % 3] = u;
                                p[(axis + 2) % 3] = v;
                                *known.entry(p).or_insert_with(|| {
                                    mesh.vertices.push(p.map(f64::from));
                                    mesh.vertices.len() - 1
                                })
                            });
                        let halves = if (u + v) % 2 == 0 {
                            [[a, b, c], [a, c, d]]
                        } else {
                            [[a, b, d], [b, c, d]]
                        };
                        let flip =
                            |[a, b, c]: [usize; 3]| if side < 0 { [a, c, b] } else { [a, b, c] };
                        mesh.faces.extend(halves.map(flip));
                    }
                }
            }
        }
        mesh
    }

    /// Returns the mesh with a function applied to every vertex.
    pub fn map(mut self, f: impl FnMut([f64; 3]) -> [f64; 3]) -> Self {
        self.vertices = self.vertices.into_iter().map(f).collect();
        self
    }

    /// Returns the faces as triangles, with vertices rounded to f32.
    pub fn triangles(&self) -> Vec<Triangle> {
        let corner = |v: usize| self.vertices[v].map(|x| x as f32);
        self.faces.iter().map(|face| Triangle(face.map(corner))).collect()
    }
}

/// Returns the unit vector in the direction of a vector.
fn unit([x, y, z]: [f64; 3]) -> [f64; 3] {
    let length = (x * x + y * y + z * z).sqrt();
    [x / length, y / length, z / length]
}

/// Returns point `i` of `n` on the unit circle, computed by normalizing a point on a square. Unlike
/// a sine, a square root has the same bits on every machine.
fn circle(i: usize, n: usize) -> [f64; 2] {
    let walk = 4.0 * i as f64 / n as f64;
    let (side, along) = (walk as usize, 2.0 * (walk - (walk as usize) as f64) - 1.0);
    let [x, y] = [[1.0, along], [-along, 1.0], [-1.0, -along], [along, -1.0]][side % 4];
    let length = (x * x + y * y).sqrt();
    [x / length, y / length]
}

#[cfg(test)]
mod tests {
    use super::Mesh;
    use std::collections::BTreeMap;

    fn meshes() -> [(Mesh, usize, i64); 6] {
        [
            (Mesh::icosphere(0), 20, 2),
            (Mesh::icosphere(2), 320, 2),
            (Mesh::torus(3, 3), 18, 0),
            (Mesh::torus(40, 25), 2000, 0),
            (Mesh::cube(1), 48, 2),
            (Mesh::cube(4), 768, 2),
        ]
    }

    #[test]
    fn every_edge_runs_once_each_way() {
        for (mesh, faces, euler) in meshes() {
            assert_eq!(mesh.faces.len(), faces);
            let mut edges = BTreeMap::new();
            for &[a, b, c] in &mesh.faces {
                for edge in [(a, b), (b, c), (c, a)] {
                    *edges.entry(edge).or_insert(0) += 1;
                }
            }
            assert!(edges.iter().all(|(&(a, b), &n)| n == 1 && edges.contains_key(&(b, a))));
            let (v, e) = (mesh.vertices.len() as i64, edges.len() as i64 / 2);
            assert_eq!(v - e + faces as i64, euler);
        }
    }

    #[test]
    fn faces_look_outward() {
        // The signed volume of a closed mesh whose faces point outward is positive.
        for (mesh, ..) in meshes() {
            let volume: f64 = (mesh.faces.iter())
                .map(|face| {
                    let [[ax, ay, az], [bx, by, bz], [cx, cy, cz]] = face.map(|v| mesh.vertices[v]);
                    ax * (by * cz - bz * cy) + ay * (bz * cx - bx * cz) + az * (bx * cy - by * cx)
                })
                .sum();
            assert!(volume > 0.1, "{volume}");
        }
    }
}
