//! The triangles of a mesh, as engines take them.

use intertri::Triangle;
use intertri_scene::Mesh;

use crate::error::{Error, Result};

/// [`Mesh::to_triangles`], or an error where there is too little memory.
pub(crate) fn triangles(mesh: &Mesh) -> Result<Vec<Triangle>> {
    let (mut triangles, count) = (Vec::new(), mesh.triangles.len());
    let room = triangles.try_reserve_exact(count);
    room.map_err(|_| Error::no_memory(format_args!("{count} triangles")))?;
    triangles.extend((0..count).map(|i| Triangle(mesh.corners(i))));
    Ok(triangles)
}
