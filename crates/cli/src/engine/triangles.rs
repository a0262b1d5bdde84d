//! The triangles of a mesh, as engines take them.

use intertri::Triangle;
use intertri_scene::Mesh;

use crate::engine::memory::room;
use crate::error::Result;

/// [`Mesh::to_triangles`], or an error where there is too little memory.
pub(crate) fn triangles(mesh: &Mesh) -> Result<Vec<Triangle>> {
    let count = mesh.triangles.len();
    let mut triangles = room(count, "triangles")?;
    triangles.extend((0..count).map(|i| Triangle(mesh.corners(i))));
    Ok(triangles)
}
