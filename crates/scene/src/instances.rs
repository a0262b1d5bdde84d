//! Meshes that are shared by several instances, each with its own placement.

use intertri::Triangle64;

use crate::mesh::Mesh;

/// A placement of a mesh.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Instance {
    /// The index of the mesh.
    pub mesh: u32,
    /// Three rows of four numbers, row by row: a corner (x, y, z) is placed at `((m0 x + m1 y) + m2 z) + m3` along the
    /// first axis, and so on, with each operation rounded in f64.
    pub matrix: [f64; 12],
}

/// A model as meshes and their placements.
///
/// ```
/// use intertri_scene::{Instance, InstancedMesh, Mesh};
/// let mesh = Mesh {
///     positions: vec![[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]],
///     triangles: vec![[0, 1, 2]],
///     ..Mesh::default()
/// };
/// let at = |z| [1.0, 0.0, 0.0, 0.0, /**/ 0.0, 1.0, 0.0, 0.0, /**/ 0.0, 0.0, 1.0, z];
/// let instances = [3.0, 5.0].map(|z| Instance { mesh: 0, matrix: at(z) }).to_vec();
/// let model = InstancedMesh { meshes: vec![mesh], instances };
/// assert!(model.is_shared() && model.triangles() == 2);
/// assert_eq!(model.triangle(1, 0).0[1], [1.0, 0.0, 5.0]);
/// ```
#[derive(Clone, Debug, Default, PartialEq)]
pub struct InstancedMesh {
    /// The meshes, in their own coordinates.
    pub meshes: Vec<Mesh<f64>>,
    /// The placements, in the order of the file.
    pub instances: Vec<Instance>,
}

impl InstancedMesh {
    /// The matrix that leaves a mesh where it is.
    pub const IDENTITY: [f64; 12] = [1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0];

    /// A mesh that is used once, where it is.
    pub fn of(mesh: Mesh<f64>) -> Self {
        Self { meshes: vec![mesh], instances: vec![Instance { mesh: 0, matrix: Self::IDENTITY }] }
    }

    /// Whether there are more instances than meshes.
    pub fn is_shared(&self) -> bool {
        self.instances.len() > self.meshes.len()
    }

    /// The number of triangles of all instances.
    pub fn triangles(&self) -> u64 {
        let of = |instance: &Instance| self.meshes[instance.mesh as usize].triangles.len() as u64;
        self.instances.iter().map(of).sum()
    }

    /// A triangle of an instance, where it is placed.
    ///
    /// # Panics
    /// Panics if there is no such instance or triangle.
    pub fn triangle(&self, instance: usize, triangle: usize) -> Triangle64 {
        let Instance { mesh, matrix } = &self.instances[instance];
        let corners = self.meshes[*mesh as usize].corners(triangle);
        Triangle64(corners.map(|corner| placed(matrix, corner)))
    }

    /// The points that triangles of instances use, where they are placed.
    pub fn points(&self) -> impl Iterator<Item = [f64; 3]> {
        let used: Vec<Vec<[f64; 3]>> = self.meshes.iter().map(used_positions).collect();
        (0..self.instances.len()).flat_map(move |instance| {
            let Instance { mesh, matrix } = self.instances[instance];
            let count = used[mesh as usize].len();
            let points: Vec<_> =
                (0..count).map(|i| placed(&matrix, used[mesh as usize][i])).collect();
            points
        })
    }
}

/// The positions that triangles of a mesh use, each once.
fn used_positions(mesh: &Mesh<f64>) -> Vec<[f64; 3]> {
    let mut is_used = vec![false; mesh.positions.len()];
    for &corner in mesh.triangles.as_flattened() {
        is_used[corner as usize] = true;
    }
    let all = mesh.positions.iter().zip(is_used);
    all.filter(|(_, is_used)| *is_used).map(|(position, _)| *position).collect()
}

/// A point of a mesh, where an instance places it.
pub(crate) fn placed(m: &[f64; 12], [x, y, z]: [f64; 3]) -> [f64; 3] {
    [0, 4, 8].map(|i| ((m[i] * x + m[i + 1] * y) + m[i + 2] * z) + m[i + 3])
}
