//! The interface through which cameras, lights, and shading access a scene's triangles, whether in
//! a single mesh or in instances.

use intertri::{Hit, TriangleOf};

use crate::coordinate::Coordinate;
use crate::instances::InstancedMesh;
use crate::mesh::{Bounds, Mesh, Part};

/// The triangles of a [`Scene`](crate::Scene): a [`Mesh`] or, in f64, an [`InstancedMesh`].
///
/// In a hit on a mesh, `triangle` is the index of the triangle. In a hit on an instance, `triangle`
/// is the index of the triangle within the instance's mesh, and `geometry` is the index of the
/// instance.
pub trait SceneGeometry<S: Coordinate>: Sync {
    /// Returns the number of triangles.
    fn triangle_count(&self) -> u64;

    /// Iterates over the corners of all triangles, each at least once.
    fn corner_points(&self) -> impl Iterator<Item = [S; 3]>;

    /// Iterates over points whose convex hull contains all triangles. These are the triangles'
    /// corners, unless the scene has so many instances that visiting all corners would take too
    /// long. In that case, the hull may be larger.
    fn enclosing_points(&self) -> impl Iterator<Item = [S; 3]> {
        self.corner_points()
    }

    /// Returns the triangle of a hit.
    fn triangle_of(&self, hit: &Hit) -> TriangleOf<S>;

    /// Returns whether any mesh has texture coordinates.
    fn has_uvs(&self) -> bool;

    /// Returns the texture coordinates at the corners of a hit's triangle, or `None` if its mesh
    /// has no texture coordinates.
    fn uvs_of(&self, hit: &Hit) -> Option<&[[f32; 2]; 3]>;

    /// Returns the part that a hit's triangle belongs to, or `None` if it belongs to no part.
    fn part_of(&self, hit: &Hit) -> Option<&Part>;

    /// Returns the bounding box of [`SceneGeometry::enclosing_points`], which contains all
    /// triangles, or `None` if there are no triangles.
    fn bounding_box(&self) -> Option<Bounds<S>> {
        Bounds::around(self.enclosing_points())
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

    fn enclosing_points(&self) -> impl Iterator<Item = [f64; 3]> {
        InstancedMesh::enclosing_points(self)
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
