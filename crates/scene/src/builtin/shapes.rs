//! Generated shapes: grids, surfaces of revolution, wedges, and spheres.
//!
//! Neighbouring triangles of a shape share vertices, even across its seams, so adjacency follows
//! from the indices. Texture coordinates belong to triangle corners and may differ between
//! neighbours.

use std::collections::HashMap;
use std::f64::consts::TAU;

use glam::DVec3;

use crate::mesh::{Mesh, Part, rounded};

/// A ring of vertices on a surface of revolution: its radius (0 for a pole), its height, and its
/// rotation relative to the other rings, as a fraction of a side.
pub(super) struct Ring {
    pub(super) radius: f64,
    pub(super) y: f64,
    pub(super) turn: f64,
}

/// The mesh under construction.
#[derive(Default)]
pub(super) struct Shapes {
    pub(super) mesh: Mesh,
}

impl Shapes {
    /// Begins a part: the following shapes have this albedo, and the texture if `textured`.
    pub(super) fn part(&mut self, tint: [f32; 3], textured: bool) {
        self.mesh.parts.push(Part { first: self.mesh.triangles.len() as u32, tint, textured });
    }

    /// Adds a surface of `cells` quads. `place` maps u and v in `0..=1` to points, and `closed`
    /// states whether u and v wrap around. The texture repeats `repeat` times along u and, assuming
    /// roughly square quads, proportionally along v.
    pub(super) fn grid(
        &mut self,
        cells: [u32; 2],
        closed: [bool; 2],
        repeat: f32,
        place: impl Fn(f64, f64) -> DVec3,
    ) {
        let count = [0, 1].map(|axis| cells[axis] + u32::from(!closed[axis]));
        let first = self.mesh.positions.len() as u32;
        for j in 0..count[1] {
            for i in 0..count[0] {
                let [u, v] =
                    [f64::from(i) / f64::from(cells[0]), f64::from(j) / f64::from(cells[1])];
                self.position(place(u, v));
            }
        }
        let scale = repeat / cells[0] as f32;
        for j in 0..cells[1] {
            for i in 0..cells[0] {
                let at = |i: u32, j: u32| {
                    let place = first + j % count[1] * count[0] + i % count[0];
                    (place, [i as f32 * scale, j as f32 * scale])
                };
                self.quad([at(i, j), at(i, j + 1), at(i + 1, j + 1), at(i + 1, j)]);
            }
        }
    }

    /// Adds a surface of revolution with `sides` sides around the y axis through `rings`,
    /// transformed by `place`. Only the first and the last ring may be poles.
    pub(super) fn lathe(&mut self, sides: u32, rings: &[Ring], place: impl Fn(DVec3) -> DVec3) {
        // Add the positions, and record where each ring starts.
        let starts: Vec<u32> = rings
            .iter()
            .map(|ring| {
                let start = self.mesh.positions.len() as u32;
                for side in 0..if ring.radius > 0.0 { sides } else { 1 } {
                    let angle = TAU * (f64::from(side) + ring.turn) / f64::from(sides);
                    let (sin, cos) = angle.sin_cos();
                    self.position(place(DVec3::new(ring.radius * cos, ring.y, ring.radius * sin)));
                }
                start
            })
            .collect();

        for (row, pair) in rings.windows(2).enumerate() {
            let corner = |ring: usize, side: u32| {
                let wrapped = if rings[ring].radius > 0.0 { side % sides } else { 0 };
                let u = (side as f32 + rings[ring].turn as f32) / sides as f32;
                (starts[ring] + wrapped, [8.0 * u, ring as f32])
            };
            for side in 0..sides {
                let (low, low_next) = (corner(row, side), corner(row, side + 1));
                let (high, high_next) = (corner(row + 1, side), corner(row + 1, side + 1));
                // Between rings with different rotations, diagonals must follow the rotation;
                // otherwise, facets would cross.
                let (first, second) = if pair[1].turn < pair[0].turn {
                    ([low, high, high_next], [low, high_next, low_next])
                } else {
                    ([low, high, low_next], [low_next, high, high_next])
                };
                match (pair[0].radius > 0.0, pair[1].radius > 0.0) {
                    (true, true) => {
                        self.triangle(first);
                        self.triangle(second);
                    }
                    (true, false) => self.triangle([low, high, low_next]),
                    _ => self.triangle([low, high, high_next]),
                }
            }
        }
    }

    /// Adds a sector of a flat ring around the y axis, between two radii and two angles. The sector
    /// extends upward from `y` by `height`.
    pub(super) fn wedge(&mut self, radii: [f64; 2], y: f64, height: f64, angles: [f64; 2]) {
        let first = self.mesh.positions.len() as u32;
        for corner in 0..8_usize {
            let (radius, angle) = (radii[corner & 1], angles[corner >> 1 & 1]);
            let (sin, cos) = angle.sin_cos();
            let y = y + height * f64::from(corner as u32 >> 2);
            self.position(DVec3::new(radius * cos, y, radius * sin));
        }
        let faces =
            [[0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6], [0, 2, 6, 4], [1, 5, 7, 3]];
        let uvs = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]];
        for face in faces {
            self.quad(std::array::from_fn(|i| (first + face[i], uvs[i])));
        }
    }

    /// Adds a unit sphere, transformed by `place`: an icosahedron with every triangle split into
    /// four, `levels` times.
    pub(super) fn icosphere(&mut self, levels: u32, place: impl Fn(DVec3) -> DVec3) {
        // The corners of an icosahedron are the corners of three golden rectangles.
        let golden = f64::midpoint(1.0, 5.0_f64.sqrt());
        let mut points: Vec<DVec3> = Vec::new();
        for axis in 0..3 {
            for (a, b) in [(1.0, golden), (-1.0, golden), (1.0, -golden), (-1.0, -golden)] {
                let mut p = [0.0; 3];
                (p[axis], p[(axis + 1) % 3]) = (a, b);
                points.push(DVec3::from(p).normalize());
            }
        }
        // The icosahedron's faces are all triples of neighbouring corners, facing outward.
        let near = |a: usize, b: usize| points[a].dot(points[b]) > 0.4;
        let mut faces: Vec<[usize; 3]> = Vec::new();
        for a in 0..12 {
            for b in a + 1..12 {
                for c in b + 1..12 {
                    if near(a, b) && near(b, c) && near(c, a) {
                        let outward = points[a].cross(points[b]).dot(points[c]) > 0.0;
                        faces.push(if outward { [a, b, c] } else { [a, c, b] });
                    }
                }
            }
        }

        for _ in 0..levels {
            let mut midpoints = HashMap::new();
            let mut midpoint = |a: usize, b: usize| {
                *midpoints.entry((a.min(b), a.max(b))).or_insert_with(|| {
                    points.push((points[a] + points[b]).normalize());
                    points.len() - 1
                })
            };
            let finer = faces.iter().flat_map(|&[a, b, c]| {
                let (ab, bc, ca) = (midpoint(a, b), midpoint(b, c), midpoint(c, a));
                [[a, ab, ca], [b, bc, ab], [c, ca, bc], [ab, bc, ca]]
            });
            faces = finer.collect();
        }

        let first = self.mesh.positions.len() as u32;
        for &p in &points {
            self.position(place(p));
        }
        for face in faces {
            // Longitude and latitude. Across the seam, a triangle's longitude continues beyond 1.
            let mut uvs = face.map(|i| {
                let p = points[i];
                [p.z.atan2(p.x) / TAU + 0.5, p.y.clamp(-1.0, 1.0).asin() * 2.0 / TAU + 0.5]
            });
            let largest = uvs[0][0].max(uvs[1][0]).max(uvs[2][0]);
            for uv in &mut uvs {
                uv[0] += f64::from(largest - uv[0] > 0.5);
            }
            self.triangle(std::array::from_fn(|i| {
                (first + face[i] as u32, uvs[i].map(|x| 8.0 * x as f32))
            }));
        }
    }

    fn position(&mut self, p: DVec3) {
        self.mesh.positions.push(rounded(p));
    }

    fn quad(&mut self, [a, b, c, d]: [(u32, [f32; 2]); 4]) {
        self.triangle([a, b, c]);
        self.triangle([a, c, d]);
    }

    fn triangle(&mut self, corners: [(u32, [f32; 2]); 3]) {
        self.mesh.triangles.push(corners.map(|(index, _)| index));
        self.mesh.corner_uvs.get_or_insert_with(Vec::new).push(corners.map(|(_, uv)| uv));
    }
}
