//! Generates rays that leave a closed convex mesh exactly at its edges and vertices.

use intertri::Ray;

use super::vector::round;
use crate::meshes::Mesh;
use crate::rng::Rng;
use crate::test_batch::TestBatch;

/// Creates a convex mesh on a grid with spacing `2^-bits` and rays from inside it, each aimed
/// exactly at a vertex, or at the midpoint or a quarter point of an edge. If `bits` is at most 18,
/// origins, directions, and targets are free of rounding; if it is at most 15, the grid of the
/// `fixed` mode also preserves them. Each ray leaves the mesh at one point.
pub fn closed_mesh(rng: &mut Rng, bits: u32, rays: usize) -> TestBatch {
    let steps = f64::from(1_u32 << bits);
    let stretch = [0; 3].map(|_| 0.5 + 0.49 * rng.unit());
    let mesh = if rng.one_in(4) { Mesh::cube(1) } else { Mesh::icosphere(1) };
    let mesh = mesh.map(|p| [0, 1, 2].map(|k| (p[k] * stretch[k] * steps) as i32 as f64));
    let rays = (0..rays)
        .map(|_| {
            let reach = (0.25 * steps) as i32;
            let origin = [0; 3].map(|_| f64::from(rng.within(reach)));
            let face = rng.pick(&mesh.faces);
            let corner = rng.below(3);
            let [a, b] = [face[corner], face[(corner + 1) % 3]].map(|v| mesh.vertices[v]);
            // Choose the weight of the edge's second end, in quarters.
            let weight = rng.pick(&[0.0, 0.0, 0.0, 1.0, 2.0, 3.0]);
            let dir = [0, 1, 2].map(|k| (4.0 - weight) * a[k] + weight * b[k] - 4.0 * origin[k]);
            Ray::new(round(origin.map(|x| x / steps)), round(dir.map(|x| x / steps)))
        })
        .collect();
    let triangles = mesh.map(|p| p.map(|x| x / steps)).triangles();
    TestBatch { rays, triangles }
}
