//! Meshes that several instances share, each with its own transform.

use intertri::Triangle64;

use crate::mesh::Mesh;

/// An instance: a mesh and the transform that places it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Instance {
    /// The index of the mesh.
    pub mesh: u32,
    /// The transform, as a row-major 3×4 matrix. The first row maps a vertex (x, y, z) to the x
    /// coordinate `((m0 x + m1 y) + m2 z) + m3`, with each operation rounded to f64. The other two
    /// rows compute y and z in the same way.
    pub matrix: [f64; 12],
}

/// A model made of meshes and instances of them.
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
    /// The instances, in the order of the file.
    pub instances: Vec<Instance>,
}

impl InstancedMesh {
    /// The identity transform.
    pub const IDENTITY: [f64; 12] = [1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0];

    /// Creates a model with a single, untransformed instance of a mesh.
    pub fn of(mesh: Mesh<f64>) -> Self {
        Self { meshes: vec![mesh], instances: vec![Instance { mesh: 0, matrix: Self::IDENTITY }] }
    }

    /// Returns whether there are more instances than meshes.
    pub fn is_shared(&self) -> bool {
        self.instances.len() > self.meshes.len()
    }

    /// Returns the total number of triangles in all instances.
    pub fn triangles(&self) -> u64 {
        let of = |instance: &Instance| self.meshes[instance.mesh as usize].triangles.len() as u64;
        self.instances.iter().map(of).sum()
    }

    /// Returns a triangle of an instance, transformed by the instance's matrix.
    ///
    /// # Panics
    /// Panics if there is no such instance or triangle.
    pub fn triangle(&self, instance: usize, triangle: usize) -> Triangle64 {
        let Instance { mesh, matrix } = &self.instances[instance];
        let corners = self.meshes[*mesh as usize].corners(triangle);
        Triangle64(corners.map(|corner| placed(matrix, corner)))
    }

    /// Iterates over the transformed vertices of all instances. Vertices that no triangle uses are
    /// skipped.
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

/// Returns the positions that a mesh's triangles use, each once.
fn used_positions(mesh: &Mesh<f64>) -> Vec<[f64; 3]> {
    let mut is_used = vec![false; mesh.positions.len()];
    for &corner in mesh.triangles.as_flattened() {
        is_used[corner as usize] = true;
    }
    let all = mesh.positions.iter().zip(is_used);
    all.filter(|(_, is_used)| *is_used).map(|(position, _)| *position).collect()
}

/// Transforms a point by an instance's matrix.
pub(crate) fn placed(m: &[f64; 12], [x, y, z]: [f64; 3]) -> [f64; 3] {
    [0, 4, 8].map(|i| ((m[i] * x + m[i + 1] * y) + m[i + 2] * z) + m[i + 3])
}
