//! Reads model files: Wavefront OBJ, PLY, STL, and glTF, optionally compressed with gzip.

mod builder;
mod cut;
mod error;
mod file;
mod flatten;
mod gltf;
mod gzip;
mod lines;
mod notes;
mod obj;
mod ply;
mod stl;
mod text;

use std::io::{BufRead, BufReader, Cursor, Read, Seek, SeekFrom};
use std::path::{Path, PathBuf};

pub use self::error::LoadError;
use self::error::{Fault, fault};
use self::file::{SiblingFiles, open};
use self::flatten::flatten;
pub use self::notes::{Note, Notes};
use self::text::{skip_mark, without_mark};
use crate::coordinate::Coordinate;
use crate::instances::InstancedMesh;
use crate::mesh::Mesh;

const NO_TRIANGLE: &str = "it has no triangle; is it a model?";

/// Reads a model.
///
/// The extension determines the format (`.obj`, `.ply`, `.stl`, `.gltf`, or `.glb`, in upper or
/// lower case). For any other extension, the first bytes determine the format. A gzip file is
/// unpacked first, whatever its name, and the extension `.gz` is ignored.
///
/// - A polygon with n corners becomes n - 2 consecutive triangles with the same winding: the fan
///   around its first corner (see [`Mesh`]), or the result of ear clipping if the fan would reach
///   outside. Faces with fewer than three corners are skipped.
/// - OBJ: the vertices, texture coordinates, and faces of all objects and groups, in the order of
///   the file. Negative indices count backward from the latest vertex. Points, lines, materials,
///   fourth coordinates, and colours are ignored. Lines end in a line feed, a carriage return, or
///   both.
/// - PLY: ASCII, and binary in both byte orders. The elements are `vertex` with x, y, z (and s, t
///   or u, v or `texture_u`, `texture_v`), `face` with `vertex_indices` or `vertex_index`, and
///   `tristrips` with the same property, in which -1 ends a strip. A `double` is rounded to f32.
/// - STL: ASCII (all its solids) and binary, distinguished by the size given in a binary header.
///   Triangles do not share vertices.
/// - glTF 2.0, as text and as GLB: the meshes of the default scene (the first scene if no default
///   is given, or all nodes if there is no scene). Nodes are read in order, each before its
///   children, and their meshes are placed by transforms, instances, or joints. Triangles, strips,
///   fans, weighted morph targets, and the first texture coordinates are read. A transform that
///   mirrors flips the triangles. Hidden nodes are skipped. Buffers are within the file, in data
///   URIs, or in files in the model's folder. Materials and animations are ignored, points and
///   lines are skipped, and compressed meshes are rejected.
///
/// In a strip, every other triangle is flipped, so that all have the same winding, and triangles
/// that use a vertex twice are skipped. A text file may begin with a byte order mark. Vertices,
/// texture coordinates, and other values that no triangle uses need not be valid; they may be NaN,
/// for example.
///
/// The [`Notes`] of [`load_model`] count everything that is skipped, repaired, or guessed.
///
/// Time and memory are linear in the size of the file, except that the time to cut a face by ear
/// clipping may grow with the square of its number of corners. No allocation is sized by a count in
/// the file. A gzip file may unpack to a hundred times its size, and a glTF file that repeats its
/// meshes may expand to about sixteen million vertices and triangles.
///
/// # Errors
/// Returns an error if the file cannot be read, is not a model in one of these formats, ends early,
/// refers to missing vertices, has a triangle with a coordinate that is not finite in f32, or has
/// no triangles.
pub fn load(path: &Path) -> Result<Mesh, LoadError> {
    load_model(path).map(|model| model.mesh)
}

/// The result of [`load_model`].
#[derive(Clone, Debug)]
pub struct LoadedModel<S = f32> {
    /// The triangles.
    pub mesh: Mesh<S>,
    /// Other files that were read for the model: the buffers of a glTF file.
    pub files: Vec<PathBuf>,
    /// Notes on what was skipped, repaired, or guessed; empty for most models.
    pub notes: Notes,
}

/// Reads a model as [`load`] does, but in f32 or f64, and also returns notes about it and the other
/// files that were read.
///
/// In f64, decimals in text are rounded once to f64, a `double` in a PLY file is kept, and
/// transformed positions in a glTF file are not rounded to f32. Numbers that a file stores in f32
/// are unchanged: a `float` in binary PLY, all numbers in binary STL, and the positions in glTF
/// before they are transformed.
///
/// # Errors
/// Returns an error under the same conditions as [`load`], for the requested scalar.
pub fn load_model<S: Coordinate>(path: &Path) -> Result<LoadedModel<S>, LoadError> {
    let folder = path.parent().unwrap_or(Path::new(""));
    let mut beside = SiblingFiles { folder, read: vec![] };
    let read = open(path).and_then(|file| unpacked(path, BufReader::new(file), Some(&mut beside)));
    let read = read.and_then(|(content, notes)| Ok((content.mesh()?, notes)));
    let (mesh, notes) = read.map_err(|fault| fault.of(path))?;
    Ok(LoadedModel { mesh, files: beside.read, notes })
}

/// The result of [`load_instances`].
#[derive(Clone, Debug)]
pub struct LoadedInstances {
    /// The meshes and their instances.
    pub model: InstancedMesh,
    /// Other files that were read for the model: the buffers of a glTF file.
    pub files: Vec<PathBuf>,
    /// Notes on what was skipped, repaired, or guessed; empty for most models.
    pub notes: Notes,
    path: PathBuf,
    /// The maximum number of vertices and triangles after flattening, or `None` if the model is a
    /// single, untransformed mesh.
    most: Option<u64>,
}

/// Reads a model like [`load_model`] in f64, but keeps instances of shared meshes instead of
/// flattening them. In a glTF file, nodes that share a mesh, and nodes with the extension
/// `EXT_mesh_gpu_instancing`, become instances. A model in any other format becomes a single,
/// untransformed instance of one mesh.
///
/// A transform that mirrors flips the triangles, so a mesh that is used both with and without
/// mirroring becomes two meshes. A mesh is also duplicated for each use with a skin, and for each
/// different set of morph target weights.
///
/// # Errors
/// Returns an error under the same conditions as [`load`], for f64.
pub fn load_instances(path: &Path) -> Result<LoadedInstances, LoadError> {
    let folder = path.parent().unwrap_or(Path::new(""));
    let mut beside = SiblingFiles { folder, read: vec![] };
    let read = open(path).and_then(|file| unpacked(path, BufReader::new(file), Some(&mut beside)));
    let read = read.and_then(|(content, notes)| {
        let (model, most) = match content {
            Content::Mesh(mesh) => (InstancedMesh::of(mesh), None),
            Content::Instanced { model, most } => (model, Some(most)),
        };
        if let Some(most) = most {
            flatten::check(&model, most)?;
        }
        Ok((model, most, notes))
    });
    let (model, most, notes) = read.map_err(|fault| fault.of(path))?;
    Ok(LoadedInstances { model, files: beside.read, notes, path: path.into(), most })
}

impl LoadedInstances {
    /// Flattens all instances into one mesh, which yields the model that [`load_model`] returns.
    ///
    /// # Errors
    /// Returns an error if the instances have more vertices or triangles than one mesh may have, or
    /// if memory runs out.
    pub fn flatten(self) -> Result<LoadedModel<f64>, LoadError> {
        let Self { mut model, files, notes, path, most } = self;
        let mesh = match most {
            None => model.meshes.pop().unwrap_or_default(),
            Some(most) => flatten(model, most).map_err(|fault| fault.of(&path))?,
        };
        Ok(LoadedModel { mesh, files, notes })
    }
}

/// Reads a model like [`load`] from bytes in memory, as if from a file named `path`.
///
/// # Errors
/// Returns an error under the same conditions as [`load`], and also if a glTF model has buffers in
/// other files, because there is no folder to look in.
///
/// ```
/// let mesh = intertri_scene::read("a.obj".as_ref(), b"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n")?;
/// assert_eq!(mesh.triangles, [[0, 1, 2]]);
/// # Ok::<_, intertri_scene::LoadError>(())
/// ```
pub fn read(path: &Path, bytes: &[u8]) -> Result<Mesh, LoadError> {
    let read = unpacked(path, Cursor::new(bytes), None).and_then(|(content, _)| content.mesh());
    read.map_err(|fault| fault.of(path))
}

/// The content of a model file.
enum Content<S> {
    Mesh(Mesh<S>),
    /// Meshes and instances, and the maximum number of vertices and triangles after flattening.
    Instanced {
        model: InstancedMesh,
        most: u64,
    },
}

impl<S: Coordinate> Content<S> {
    /// Returns all triangles as one mesh.
    fn mesh(self) -> Result<Mesh<S>, Fault> {
        match self {
            Self::Mesh(mesh) => Ok(mesh),
            Self::Instanced { model, most } => flatten(model, most),
        }
    }
}

/// Reads a model from a file that may be compressed with gzip.
fn unpacked<S: Coordinate>(
    path: &Path,
    mut input: impl BufRead + Seek,
    beside: Option<&mut SiblingFiles<'_>>,
) -> Result<(Content<S>, Notes), Fault> {
    let size = input.seek(SeekFrom::End(0))?;
    input.rewind()?;
    if input.fill_buf()?.starts_with(gzip::MAGIC) {
        let mut notes = Notes::default();
        let bytes = gzip::unpack(input, size, &mut notes)?;
        if bytes.starts_with(gzip::MAGIC) {
            return fault("is a gzip in a gzip; unpack it first (gunzip)");
        }
        let size = bytes.len() as u64;
        let (content, more) = model(&gzip::inner(path), Cursor::new(bytes), size, beside)?;
        notes.extend(more);
        return Ok((content, notes));
    }
    model(path, input, size, beside)
}

/// Reads a model from a file with the given name and size. The input must be positioned at its
/// start.
fn model<S: Coordinate>(
    path: &Path,
    mut input: impl BufRead + Seek,
    size: u64,
    beside: Option<&mut SiblingFiles<'_>>,
) -> Result<(Content<S>, Notes), Fault> {
    if size == 0 {
        return fault("the file is empty");
    }
    let format = format(path, &mut input, size)?;
    if !matches!(format, Format::Stl) {
        skip_mark(&mut input)?;
    }
    let (mesh, notes) = match format {
        Format::Obj => obj::read(input)?,
        Format::Ply => ply::read(input)?,
        Format::Stl => stl::read(input, size)?,
        Format::Gltf => {
            let gltf::Gltf { model, notes, most } = gltf::read(input, beside)?;
            if model.instances.is_empty() {
                return fault(NO_TRIANGLE);
            }
            return Ok((Content::Instanced { model, most }, notes));
        }
    };
    if mesh.triangles.is_empty() {
        return fault(NO_TRIANGLE);
    }
    Ok((Content::Mesh(mesh), notes))
}

enum Format {
    Obj,
    Ply,
    Stl,
    Gltf,
}

/// Determines the format from the extension or, failing that, from the first bytes.
fn format(path: &Path, input: &mut (impl Read + Seek), size: u64) -> Result<Format, Fault> {
    let extension = path.extension().unwrap_or_default().to_ascii_lowercase();
    match extension.to_str() {
        Some("obj") => return Ok(Format::Obj),
        Some("ply") => return Ok(Format::Ply),
        Some("stl") => return Ok(Format::Stl),
        Some("gltf" | "glb") => return Ok(Format::Gltf),
        _ => {}
    }
    let mut start = Vec::new();
    input.by_ref().take(0x1_0000).read_to_end(&mut start)?;
    input.rewind()?;
    let text = without_mark(&start);
    if text.starts_with(b"ply") {
        Ok(Format::Ply)
    } else if gltf::looks_like(text) {
        Ok(Format::Gltf)
    } else if stl::looks_like(&start, size) {
        Ok(Format::Stl)
    } else if obj::looks_like(text) {
        Ok(Format::Obj)
    } else {
        fault("is neither OBJ nor PLY nor STL nor glTF; convert it, or give it the right extension")
    }
}
