//! Meshes in indexed form: vertices plus three vertex indices per triangle.

use intertri::{Scalar, TriangleOf};

use super::Bvh;
use crate::build::BuildError;
use crate::refit::{Refit, RefitError};
use crate::scalar::BvhScalar;
use crate::tree::Tree;
use crate::util::memory::NoMemory;
use crate::util::threads;

/// A mesh in indexed form: vertices, and three vertex indices per triangle.
///
/// ```
/// use intertri_trace::{Bvh, IndexedMesh};
/// let vertices = [[0.0, 0.0, 5.0_f32], [1.0, 0.0, 5.0], [0.0, 1.0, 5.0]];
/// let mesh = IndexedMesh { vertices: &vertices, indices: &[[0, 1, 2]] };
/// assert_eq!(Bvh::from_indexed_meshes(&[mesh, mesh])?.geometries(), 2);
/// # Ok::<(), intertri_trace::BuildError>(())
/// ```
#[derive(Clone, Copy, Debug)]
pub struct IndexedMesh<'a, S = f32> {
    /// The vertices.
    pub vertices: &'a [[S; 3]],
    /// The vertex indices of each triangle.
    pub indices: &'a [[u32; 3]],
}

/// A vertex index that is out of bounds.
pub(crate) struct BadIndex {
    pub(crate) triangle: usize,
    pub(crate) index: u32,
}

impl<S: BvhScalar> Bvh<S> {
    /// Builds a hierarchy over triangles that share vertices.
    ///
    /// # Errors
    /// Returns an error if an index is out of bounds, if there are 2^31 triangles or more, or if
    /// memory runs out.
    ///
    /// ```
    /// use intertri_trace::Bvh;
    /// use intertri_trace::intertri::Ray;
    /// let vertices = [[0.0, 0.0, 5.0_f32], [1.0, 0.0, 5.0], [0.0, 1.0, 5.0], [1.0, 1.0, 5.0]];
    /// let bvh = Bvh::from_indexed(&vertices, &[[0, 1, 2], [3, 2, 1]])?;
    /// assert_eq!(bvh.closest(&Ray::new([0.7, 0.7, 0.0], [0.0, 0.0, 1.0])).unwrap().triangle, 1);
    /// let error = Bvh::from_indexed(&vertices, &[[0, 1, 4]]).unwrap_err();
    /// assert_eq!(error.to_string(), "triangle 0 has vertex 4, but there are 4 vertices");
    /// # Ok::<(), intertri_trace::BuildError>(())
    /// ```
    pub fn from_indexed(vertices: &[[S; 3]], indices: &[[u32; 3]]) -> Result<Self, BuildError> {
        let mesh = IndexedMesh { vertices, indices };
        Tree::check_count(indices.len())?;
        // Check all indices first, because an invalid one would panic below.
        check(&mesh).map_err(|bad| bad.into_build_error(0, vertices.len()))?;
        let corners = threads::each(indices.len(), |i| mesh.triangle(i));
        let out_of_memory = |NoMemory| BuildError::OutOfMemory { count: indices.len() };
        Self::new(&corners.map_err(out_of_memory)?)
    }

    /// Like [`Bvh::from_meshes`], but for indexed meshes.
    ///
    /// # Errors
    /// Returns an error if an index is out of bounds, if there are 2^31 triangles or more, or if
    /// memory runs out.
    ///
    /// See [`IndexedMesh`] for an example.
    pub fn from_indexed_meshes(meshes: &[IndexedMesh<'_, S>]) -> Result<Self, BuildError> {
        let count = meshes.iter().map(|mesh| mesh.indices.len()).sum();
        Tree::check_count(count)?;
        let mut corners = Vec::new();
        for (geometry, mesh) in meshes.iter().enumerate() {
            check(mesh).map_err(|bad| bad.into_build_error(geometry, mesh.vertices.len()))?;
            threads::extend(&mut corners, mesh.indices.len(), 1 << 9, |i| mesh.triangle(i))
                .map_err(|NoMemory| BuildError::OutOfMemory { count })?;
        }
        Self::of_geometries(&corners, meshes.iter().map(|mesh| mesh.indices.len()))
    }

    /// Like [`Bvh::refit`], but takes the new vertices of an indexed mesh.
    ///
    /// # Errors
    /// Returns an error if an index is out of bounds or the number of triangles differs; the
    /// hierarchy is then unchanged. Also returns an error if memory runs out; the hierarchy is then
    /// empty.
    pub fn refit_indexed(
        &mut self,
        vertices: &[[S; 3]],
        indices: &[[u32; 3]],
    ) -> Result<Refit, RefitError> {
        let mesh = IndexedMesh { vertices, indices };
        check(&mesh).map_err(|BadIndex { triangle, index }| RefitError::BadIndex {
            triangle,
            index,
            vertices: vertices.len(),
        })?;
        let corners = threads::each(indices.len(), |i| mesh.triangle(i));
        self.refit(&corners.map_err(|NoMemory| RefitError::OutOfMemory)?)
    }
}

impl<S: Scalar> IndexedMesh<'_, S> {
    /// Returns a triangle, whose vertex indices must be in bounds.
    fn triangle(&self, i: usize) -> TriangleOf<S> {
        TriangleOf(self.indices[i].map(|index| self.vertices[index as usize]))
    }
}

/// Finds the first index that is out of bounds.
fn check<S>(mesh: &IndexedMesh<'_, S>) -> Result<(), BadIndex> {
    let bad = |&index: &u32| index as usize >= mesh.vertices.len();
    match mesh.indices.as_flattened().iter().position(bad) {
        None => Ok(()),
        Some(at) => Err(BadIndex { triangle: at / 3, index: mesh.indices[at / 3][at % 3] }),
    }
}

impl BadIndex {
    fn into_build_error(self, geometry: usize, vertices: usize) -> BuildError {
        let Self { triangle, index } = self;
        BuildError::BadIndex { geometry, triangle, index, vertices }
    }
}
