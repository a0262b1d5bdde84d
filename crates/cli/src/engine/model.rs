//! Models from files: those that the `intertri-scene` crate reads, and saved hierarchies, which do
//! not need building.
//!
//! ```text
//!   OBJ, PLY, STL, glTF ──► f64 ──┬──► f32, rounded and counted
//!   saved in f32 or f64 ──────────┴──► f64
//!   glTF with shared meshes ─────────► instances in f64, on request
//! ```

use std::fs::File;
use std::io::Read;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use clap::Args;
use intertri_scene::{
    Coordinate, InstancedMesh, Mesh, Note, Notes, Rounding, load_instances, load_model,
};
use intertri_trace::{Bvh, BvhScalar, LoadError, SAVED_MAGIC};
use serde::Serialize;

use crate::engine::memory::{filled, room};
use crate::engine::scalar_name::ScalarName;
use crate::error::{Error, Result, note};

/// A model with exactly the numbers that its file contains.
pub(crate) struct Model {
    path: PathBuf,
    content: Content,
    /// The files that were read in addition to the model.
    pub(crate) files: Vec<PathBuf>,
    /// Everything that was omitted, repaired or guessed. These notes are also printed on standard
    /// error.
    notes: ModelNotes,
}

/// The contents of the file. f64 can represent the numbers of every format.
enum Content {
    Mesh(Mesh<f64>),
    SavedF32(Bvh<f32>),
    SavedF64(Bvh<f64>),
}

/// A model in the scalar that it is traced in.
pub(crate) struct ModelIn<S: BvhScalar> {
    pub(crate) mesh: Mesh<S>,
    /// The saved hierarchy, if the file contains one in this scalar.
    pub(crate) bvh: Option<Arc<Bvh<S>>>,
    /// The coordinates that were rounded to the scalar.
    pub(crate) rounding: Rounding,
    /// Everything that was omitted, repaired or guessed.
    pub(crate) notes: ModelNotes,
}

/// A model as returned by [`Model::load_shared`].
pub(crate) enum LoadedModel {
    Model(Box<Model>),
    Instances(InstancedMesh, ModelNotes),
}

/// Options for reading a model.
#[derive(Args, Clone, Copy)]
pub(crate) struct ModelOptions {
    /// Refuse a model if something in it would be omitted, repaired or guessed, instead of only
    /// printing a warning on standard error
    #[arg(long)]
    strict: bool,
}

/// Everything in a model that was omitted, repaired or guessed: each kind with its count, for
/// reports.
#[derive(Clone, Default, Serialize)]
#[serde(transparent)]
pub(crate) struct ModelNotes(Vec<ModelNote>);

#[derive(Clone, Serialize)]
struct ModelNote {
    what: String,
    count: u64,
    /// The line of the first occurrence; null if the file is not text.
    line: Option<u64>,
}

impl ModelOptions {
    /// Prints notes about what was omitted, repaired or guessed, or refuses the model because of
    /// them.
    fn report(self, path: &Path, notes: &Notes) -> Result<ModelNotes> {
        let (name, notes) = (path.display(), notes.as_slice());
        if self.strict && !notes.is_empty() {
            let all = notes.iter().map(Note::to_string).collect::<Vec<_>>().join("; ");
            return Err(Error::at(name, format_args!("{all}; repair the file, or omit --strict")));
        }
        for found in notes {
            note(&format!("{name}: {found}"));
        }
        let of = |note: &Note| ModelNote {
            what: note.what.clone().into_owned(),
            count: note.count,
            line: note.line,
        };
        Ok(ModelNotes(notes.iter().map(of).collect()))
    }
}

impl Model {
    /// Reads a model in any format.
    pub(crate) fn load(path: &Path, options: ModelOptions) -> Result<Self> {
        let (mut files, mut notes) = (vec![], ModelNotes::default());
        let content = match saved_in(path) {
            None => {
                let model = load_model(path)?;
                notes = options.report(path, &model.notes)?;
                files = model.files;
                Content::Mesh(model.mesh)
            }
            Some(ScalarName::F32) => Content::SavedF32(saved(path)?),
            Some(ScalarName::F64) => Content::SavedF64(saved(path)?),
        };
        Ok(Self { path: path.into(), content, files, notes })
    }

    /// Reads a model in any format except saved hierarchies. It is read as instances if it has more
    /// instances than meshes, and otherwise as a single mesh, as in [`Model::load`].
    pub(crate) fn load_shared(path: &Path, options: ModelOptions) -> Result<LoadedModel> {
        let loaded = load_instances(path)?;
        let notes = options.report(path, &loaded.notes)?;
        if loaded.model.is_shared() {
            return Ok(LoadedModel::Instances(loaded.model, notes));
        }
        let model = loaded.flatten()?;
        let (content, files) = (Content::Mesh(model.mesh), model.files);
        Ok(LoadedModel::Model(Box::new(Self { path: path.into(), content, files, notes })))
    }

    /// Returns whether all numbers of the model are exact in f32. A hierarchy saved in f64 always
    /// counts as f64.
    pub(crate) fn is_f32(&self) -> bool {
        match &self.content {
            Content::Mesh(mesh) => {
                let mut rounding = Rounding::default();
                mesh.points().all(|point| {
                    for x in point {
                        rounding.round::<f32>(x);
                    }
                    rounding.numbers == 0
                })
            }
            Content::SavedF32(_) => true,
            Content::SavedF64(_) => false,
        }
    }

    /// Converts the model to f32, rounding coordinates if necessary.
    pub(crate) fn in_f32(self) -> Result<ModelIn<f32>> {
        let model = match self.content {
            Content::Mesh(mesh) => in_scalar(mesh),
            Content::SavedF32(bvh) => with_bvh(bvh),
            Content::SavedF64(bvh) => mesh(&bvh).and_then(in_scalar),
        };
        let notes = self.notes;
        model.map(|model| ModelIn { notes, ..model }).map_err(|error| error.of(&self.path))
    }

    /// Converts the model to f64.
    pub(crate) fn in_f64(self) -> Result<ModelIn<f64>> {
        let model = match self.content {
            Content::Mesh(mesh) => Ok(of_mesh(mesh, Rounding::default())),
            Content::SavedF32(bvh) => mesh(&bvh).and_then(in_scalar),
            Content::SavedF64(bvh) => with_bvh(bvh),
        };
        let notes = self.notes;
        model.map(|model| ModelIn { notes, ..model }).map_err(|error| error.of(&self.path))
    }
}

/// Returns the scalar of the saved hierarchy, if the file contains one. Also returns `None` if the
/// file cannot be read, because loading it then reports the reason.
pub(crate) fn saved_in(path: &Path) -> Option<ScalarName> {
    /// The size of the largest header of a saved hierarchy, including its table.
    const FRONT: u64 = 64 + 64 * 32;
    if !std::fs::metadata(path).ok()?.is_file() {
        return None;
    }
    let mut front = vec![];
    File::open(path).ok()?.take(FRONT).read_to_end(&mut front).ok()?;
    if !front.starts_with(&SAVED_MAGIC) {
        return None;
    }
    // The header, which comes before any section, contains the scalar.
    match Bvh::<f32>::from_bytes(&front) {
        Err(LoadError::Scalar { .. }) => Some(ScalarName::F64),
        _ => Some(ScalarName::F32),
    }
}

/// Loads a saved hierarchy and merges its meshes into one, so that triangles are numbered across
/// the whole model.
fn saved<S: BvhScalar>(path: &Path) -> Result<Bvh<S>> {
    let bvh = Bvh::load(path).map_err(|error| Error::at(path.display(), error))?;
    Ok(bvh.into_one_mesh())
}

/// Returns the model of a hierarchy that was saved in the requested scalar.
fn with_bvh<S: Coordinate + BvhScalar>(bvh: Bvh<S>) -> Result<ModelIn<S>> {
    let mesh = mesh(&bvh)?;
    Ok(ModelIn { bvh: Some(Arc::new(bvh)), ..of_mesh(mesh, Rounding::default()) })
}

/// Returns a model without a hierarchy.
fn of_mesh<S: BvhScalar>(mesh: Mesh<S>, rounding: Rounding) -> ModelIn<S> {
    ModelIn { mesh, bvh: None, rounding, notes: ModelNotes::default() }
}

/// Converts a mesh to another scalar.
fn in_scalar<S: Coordinate, T: Coordinate + BvhScalar>(mesh: Mesh<S>) -> Result<ModelIn<T>> {
    // Unused vertices may have any coordinates.
    let mut is_used = filled(mesh.positions.len(), false, "vertices")?;
    mesh.triangles.as_flattened().iter().for_each(|&corner| is_used[corner as usize] = true);
    let mut rounding = Rounding::default();
    let mut positions = room(mesh.positions.len(), "vertices")?;
    for (position, is_used) in mesh.positions.into_iter().zip(is_used) {
        let position: [f64; 3] = position.map(Into::into);
        if !is_used {
            positions.push(position.map(T::nearest));
            continue;
        }
        positions.push(position.map(|x| rounding.round::<T>(x)));
        if rounding.by_up_to == f64::INFINITY {
            let [x, y, z] = position;
            return Err(Error::new(format!(
                "the vertex ({x}, {y}, {z}) is beyond the range of {}; trace it in f64, or scale the model down",
                T::NAME
            )));
        }
    }
    let Mesh { triangles, corner_uvs, parts, .. } = mesh;
    Ok(of_mesh(Mesh { positions, triangles, corner_uvs, parts }, rounding))
}

/// Returns the triangles in a hierarchy, without shared vertices. The hierarchy does not store
/// non-finite triangles; each is replaced by a degenerate triangle at a corner of another one, so
/// that the bounds do not change.
fn mesh<S: Coordinate + BvhScalar>(bvh: &Bvh<S>) -> Result<Mesh<S>> {
    let triangles = bvh.to_triangles();
    let is_kept = |corners: &&[[S; 3]; 3]| !corners[0][0].into().is_nan();
    let Some(kept) = triangles.iter().map(|triangle| &triangle.0).find(is_kept) else {
        return Err(Error::new("has no finite triangle"));
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
