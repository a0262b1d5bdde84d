//! Converts the triangles of a mesh to the type that the engines use.

use intertri::TriangleOf;
use intertri_scene::{Coordinate, Mesh};

use crate::engine::memory::room;
use crate::error::Result;

/// Like [`Mesh::to_triangles`], but returns an error if memory runs out.
pub(crate) fn triangles<S: Coordinate>(mesh: &Mesh<S>) -> Result<Vec<TriangleOf<S>>> {
    let count = mesh.triangles.len();
    let mut triangles = room(count, "triangles")?;
    triangles.extend((0..count).map(|i| TriangleOf(mesh.corners(i))));
    Ok(triangles)
}
