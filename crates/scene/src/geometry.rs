//! What cameras, lights and shading need to know about triangles, whether they are one mesh or instances.

use intertri::{Hit, TriangleOf};

use crate::coordinate::Coordinate;
use crate::instances::InstancedMesh;
use crate::mesh::{Bounds, Mesh, Part};

/// The triangles of a [`Scene`](crate::Scene): a [`Mesh`] or, in f64, an [`InstancedMesh`].
///
/// A hit with a mesh has the number of its triangle. A hit with an instance has the number of the triangle within its
/// mesh, and that of the instance as its geometry.
pub trait SceneGeometry<S: Coordinate>: Sync {
    /// The number of triangles.
    fn triangle_count(&self) -> u64;

    /// The points that triangles use, each at least once.
    fn corner_points(&self) -> impl Iterator<Item = [S; 3]>;

    /// The triangle of a hit.
    fn triangle_of(&self, hit: &Hit) -> TriangleOf<S>;

    /// Whether there are texture coordinates.
    fn has_uvs(&self) -> bool;

    /// The texture coordinates of the corners of a hit's triangle.
    fn uvs_of(&self, hit: &Hit) -> Option<&[[f32; 2]; 3]>;

    /// The part that a hit's triangle belongs to.
    fn part_of(&self, hit: &Hit) -> Option<&Part>;

    /// The box around all triangles, or `None` if there are none.
    fn bounding_box(&self) -> Option<Bounds<S>> {
        Bounds::around(self.corner_points())
    }
}

impl<S: Coordinate> SceneGeometry<S> for Mesh<S> {
    fn triangle_count(&self) -> u64 {
        self.triangles.len() as u64
    }

    fn corner_points(&self) -> impl Iterator<Item = [S; 3]> {
        self.points()
    }

    fn triangle_of(&self, hit: &Hit) -> TriangleOf<S> {
        TriangleOf(self.corners(hit.triangle as usize))
    }

    fn has_uvs(&self) -> bool {
        self.corner_uvs.is_some()
    }

    fn uvs_of(&self, hit: &Hit) -> Option<&[[f32; 2]; 3]> {
        self.corner_uvs.as_ref().map(|uvs| &uvs[hit.triangle as usize])
    }

    fn part_of(&self, hit: &Hit) -> Option<&Part> {
        self.part(hit.triangle as usize)
    }
}

impl InstancedMesh {
    fn mesh_of(&self, hit: &Hit) -> &Mesh<f64> {
        &self.meshes[self.instances[hit.geometry as usize].mesh as usize]
    }
}

impl SceneGeometry<f64> for InstancedMesh {
    fn triangle_count(&self) -> u64 {
        self.triangles()
    }

    fn corner_points(&self) -> impl Iterator<Item = [f64; 3]> {
        self.points()
    }

    fn triangle_of(&self, hit: &Hit) -> TriangleOf<f64> {
        self.triangle(hit.geometry as usize, hit.triangle as usize)
    }

    fn has_uvs(&self) -> bool {
        self.meshes.iter().any(|mesh| mesh.corner_uvs.is_some())
    }

    fn uvs_of(&self, hit: &Hit) -> Option<&[[f32; 2]; 3]> {
        self.mesh_of(hit).uvs_of(hit)
    }

    fn part_of(&self, hit: &Hit) -> Option<&Part> {
        self.mesh_of(hit).part_of(hit)
    }
}
