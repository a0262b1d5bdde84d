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

    /// The corners of all triangles of all instances, where they are placed. Positions that no triangle uses are left
    /// out; others are repeated.
    pub fn points(&self) -> impl Iterator<Item = [f64; 3]> {
        self.instances.iter().flat_map(|Instance { mesh, matrix }| {
            self.meshes[*mesh as usize].points().map(|point| placed(matrix, point))
        })
    }
}

/// A point of a mesh, where an instance places it.
pub(crate) fn placed(m: &[f64; 12], [x, y, z]: [f64; 3]) -> [f64; 3] {
    [0, 4, 8].map(|i| ((m[i] * x + m[i + 1] * y) + m[i + 2] * z) + m[i + 3])
}
