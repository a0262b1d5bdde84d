//! Meshes that several instances share, each with its own transform.

use intertri::Triangle64;

use crate::mesh::{Bounds, Mesh};

/// The number of transformed vertices up to which [`InstancedMesh::enclosing_points`] returns the
/// vertices themselves, so that the camera is the same as for the flattened model. For each vertex
/// and triangle of the meshes, the limit grows by [`EXACT_PER_ELEMENT`].
const EXACT_POINTS: u64 = 1 << 24;

/// The amount by which the limit [`EXACT_POINTS`] grows for each vertex and triangle of the meshes.
/// The limit for flattening a file grows with the file's size, and few files have more bytes per
/// vertex and triangle than this.
const EXACT_PER_ELEMENT: u64 = 16;

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
        self.place_all(self.meshes.iter().map(used_positions).collect())
    }

    /// Iterates over points whose convex hull contains all triangles: the same points as
    /// [`InstancedMesh::points`] or, if there are too many of them, the transformed corners of each
    /// mesh's bounding box.
    ///
    /// A small file can have so many instances of so many vertices that visiting each vertex of
    /// each instance would take days. This method takes time proportional to the total size of the
    /// meshes plus the number of instances.
    pub(crate) fn enclosing_points(&self) -> impl Iterator<Item = [f64; 3]> {
        let mut points: Vec<_> = self.meshes.iter().map(used_positions).collect();
        let of = |instance: &Instance| points[instance.mesh as usize].len() as u64;
        let all: u64 = self.instances.iter().map(of).sum();
        let of = |mesh: &Mesh<f64>| (mesh.positions.len() + mesh.triangles.len()) as u64;
        let elements: u64 = self.meshes.iter().map(of).sum();
        if all > EXACT_POINTS + EXACT_PER_ELEMENT * elements {
            // Each rounded operation of `placed` is monotonic in each coordinate, so the
            // transformed corners bound the transformed vertices despite rounding.
            for points in points.iter_mut().filter(|points| points.len() > 8) {
                let bounds = Bounds::around(points.iter().copied());
                *points = bounds.map_or_else(Vec::new, |bounds| bounds.corners().to_vec());
            }
        }
        self.place_all(points)
    }

    /// Iterates over each mesh's points, transformed by each instance.
    fn place_all(&self, points: Vec<Vec<[f64; 3]>>) -> impl Iterator<Item = [f64; 3]> {
        self.instances.iter().flat_map(move |Instance { mesh, matrix }| {
            let points = points[*mesh as usize].iter().map(|&point| placed(matrix, point));
            points.collect::<Vec<_>>()
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
