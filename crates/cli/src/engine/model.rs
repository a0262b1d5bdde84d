//! Models from files: those that the scene's crate reads, and saved hierarchies, of which nothing has to be built.

use std::fs::File;
use std::io::Read;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use intertri_scene::Mesh;
use intertri_trace::{Bvh, SAVED_MAGIC};

use crate::engine::memory::room;
use crate::error::{Error, Result};

/// A model.
pub(crate) struct Model {
    pub(crate) mesh: Mesh,
    /// What was read beside the file.
    pub(crate) files: Vec<PathBuf>,
    /// The hierarchy over it, if that was saved.
    pub(crate) bvh: Option<Arc<Bvh>>,
}

/// Reads a model of any format.
pub(crate) fn load(path: &Path) -> Result<Model> {
    if !is_saved(path) {
        let (mesh, files) = intertri_scene::load_with_files(path)?;
        return Ok(Model { mesh, files, bvh: None });
    }
    let bvh = Bvh::load(path).map_err(|error| Error::at(path.display(), error))?;
    let mesh = mesh(&bvh).map_err(|error| error.of(path))?;
    Ok(Model { mesh, files: vec![], bvh: Some(Arc::new(bvh)) })
}

/// Reads a model in f64, and says what was read beside it.
pub(crate) fn load64(path: &Path) -> Result<(Mesh<f64>, Vec<PathBuf>)> {
    if is_saved(path) {
        return Err(Error::at(
            path.display(),
            "was saved in f32; leave out --scalar f64, or give the model that it was built from",
        ));
    }
    Ok(intertri_scene::load_with_files(path)?)
}

/// Whether a file begins as a saved hierarchy does. One that cannot be read is for others to tell of.
fn is_saved(path: &Path) -> bool {
    let mut start = [0; SAVED_MAGIC.len()];
    let is_file = std::fs::metadata(path).is_ok_and(|metadata| metadata.is_file());
    let read = |mut file: File| file.read_exact(&mut start);
    is_file && File::open(path).and_then(read).is_ok() && start == SAVED_MAGIC
}

/// The triangles of a hierarchy, each with positions of its own. One that can never be hit is not kept there: it
/// becomes a point of another, so that it changes no bounds.
fn mesh(bvh: &Bvh) -> Result<Mesh> {
    let triangles = bvh.to_triangles();
    let is_kept = |corners: &&[[f32; 3]; 3]| !corners[0][0].is_nan();
    let Some(kept) = triangles.iter().map(|triangle| &triangle.0).find(is_kept) else {
        return Err(Error::new("there is no triangle in it that can be hit"));
    };
    let mut positions = room(3 * triangles.len(), "corners")?;
    let mut indices = room(triangles.len(), "triangles")?;
    for corners in triangles.iter().map(|triangle| &triangle.0) {
        let first = positions.len() as u32;
        positions.extend(if is_kept(&corners) { *corners } else { [kept[0]; 3] });
        indices.push([first, first + 1, first + 2]);
    }
    Ok(Mesh { positions, triangles: indices, ..Mesh::default() })
}
