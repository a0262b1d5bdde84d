//! Models from files: those that the scene's crate reads, and saved hierarchies, of which nothing has to be built.

use std::fs::File;
use std::io::Read;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use intertri_scene::{Coordinate, Mesh};
use intertri_trace::{Bvh, Given, LoadError, SAVED_MAGIC};

use crate::engine::memory::room;
use crate::engine::scalar_name::ScalarName;
use crate::error::{Error, Result};

/// A model.
pub(crate) struct Model<S: Given = f32> {
    pub(crate) mesh: Mesh<S>,
    /// What was read beside the file.
    pub(crate) files: Vec<PathBuf>,
    /// The hierarchy over it, if that was saved.
    pub(crate) bvh: Option<Arc<Bvh<S>>>,
}

/// Reads a model of any format.
pub(crate) fn load<S: Coordinate + Given>(path: &Path) -> Result<Model<S>> {
    if saved_in(path).is_none() {
        let (mesh, files) = intertri_scene::load_with_files(path)?;
        return Ok(Model { mesh, files, bvh: None });
    }
    let bvh = Bvh::load(path).map_err(|error| match error {
        // Who can trace both has asked before.
        LoadError::Scalar { found } => Error::at(
            path.display(),
            format_args!(
                "was saved in {found}, which trace and render take; build it in {}",
                S::NAME
            ),
        ),
        error => Error::at(path.display(), error),
    })?;
    // Of several meshes as one: what hits tell are then the numbers of its triangles.
    let bvh = bvh.into_one_mesh();
    let mesh = mesh(&bvh).map_err(|error| error.of(path))?;
    Ok(Model { mesh, files: vec![], bvh: Some(Arc::new(bvh)) })
}

/// What a model is read and traced in, and what decided it, for errors.
pub(crate) struct Chosen {
    pub(crate) scalar: ScalarName,
    pub(crate) by: String,
}

/// The scalar that was asked for or, if none was, that of a saved hierarchy; of other models f32.
pub(crate) fn choose(path: Option<&Path>, asked: Option<ScalarName>) -> Result<Chosen> {
    let name = path.unwrap_or(Path::new("")).display();
    match (path.and_then(saved_in), asked) {
        (Some(saved), Some(asked)) if saved != asked => Err(Error::at(
            name,
            format_args!(
                "was saved in {saved}; leave out --scalar {asked}, or build it in {asked}"
            ),
        )),
        (Some(saved), None) => {
            Ok(Chosen { scalar: saved, by: format!("{name}, saved in {saved}") })
        }
        (_, asked) => {
            let scalar = asked.unwrap_or_default();
            Ok(Chosen { scalar, by: format!("--scalar {scalar}") })
        }
    }
}

/// The header of a saved hierarchy and its table, at most.
const FRONT: u64 = 64 + 64 * 32;

/// In which scalar a hierarchy was saved, if the file is one. What cannot be read is for others to tell of.
fn saved_in(path: &Path) -> Option<ScalarName> {
    if !std::fs::metadata(path).ok()?.is_file() {
        return None;
    }
    let mut front = vec![];
    File::open(path).ok()?.take(FRONT).read_to_end(&mut front).ok()?;
    if !front.starts_with(&SAVED_MAGIC) {
        return None;
    }
    // The scalar is found before any section is read.
    match Bvh::<f32>::from_bytes(&front) {
        Err(LoadError::Scalar { .. }) => Some(ScalarName::F64),
        _ => Some(ScalarName::F32),
    }
}

/// The triangles of a hierarchy, each with positions of its own. One that can never be hit is not kept there: it
/// becomes a point of another, so that it changes no bounds.
fn mesh<S: Coordinate + Given>(bvh: &Bvh<S>) -> Result<Mesh<S>> {
    let triangles = bvh.to_triangles();
    let is_kept = |corners: &&[[S; 3]; 3]| !corners[0][0].into().is_nan();
    let Some(kept) = triangles.iter().map(|triangle| &triangle.0).find(is_kept) else {
        return Err(Error::new("there is no triangle in it that can be hit"));
    };
    if triangles.len() > u32::MAX as usize / 3 {
        return Err(Error::new("has more than 1431655765 triangles, too many for the program"));
    }
    let mut positions = room(3 * triangles.len(), "corners")?;
    let mut indices = room(triangles.len(), "triangles")?;
    for corners in triangles.iter().map(|triangle| &triangle.0) {
        let first = positions.len() as u32;
        positions.extend(if is_kept(&corners) { *corners } else { [kept[0]; 3] });
        indices.push([first, first + 1, first + 2]);
    }
    Ok(Mesh { positions, triangles: indices, ..Mesh::default() })
}
