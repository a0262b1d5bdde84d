//! Models from files: Wavefront OBJ, PLY and STL.

mod lines;
mod obj;
mod ply;
mod stl;

use std::fs::File;
use std::io::{BufRead, BufReader, Cursor, Read, Seek, SeekFrom};
use std::path::{Path, PathBuf};
use std::{fmt, io};

use crate::mesh::Mesh;

/// Reads a model.
///
/// The format is that of the name's ending (`.obj`, `.ply` or `.stl`, in upper or lower case) and,
/// for any other ending, that which the file's beginning looks like.
///
/// - Polygons become fans in their own order, [`Mesh`] says how. A fan fills a concave polygon
///   wrongly; it is not cut into ears, because the numbers of its triangles must be plain to see.
/// - OBJ: vertices, texture coordinates and faces of all objects and groups, in the order of the
///   file; negative indices count back from the last vertex so far; points and lines are skipped,
///   materials not looked for, a fourth coordinate and colors ignored.
/// - PLY: ascii and binary of both byte orders, `vertex` with x, y, z (and s, t or u, v or `texture_u`,
///   `texture_v`) and `face` with `vertex_indices` or `vertex_index`. f64 is rounded to f32.
/// - STL: ascii (all its solids) and binary, told apart by the size that a binary header promises.
///   Every triangle has three positions of its own.
///
/// Time and memory are linear in the size of the file; what a file promises sizes nothing.
///
/// # Errors
/// If the file cannot be read, is no such model, ends early, names vertices that it lacks, has a
/// coordinate that is not finite in f32, or has no triangle at all.
pub fn load(path: &Path) -> Result<Mesh, LoadError> {
    let mesh = open(path).and_then(|file| model(path, BufReader::new(file)));
    mesh.map_err(|fault| fault.of(path))
}

/// [`load`] of bytes that are in memory: a file of that name would hold them.
///
/// # Errors
/// As [`load`].
///
/// ```
/// let mesh = intertri_scene::read("a.obj".as_ref(), b"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n")?;
/// assert_eq!(mesh.triangles, [[0, 1, 2]]);
/// # Ok::<_, intertri_scene::LoadError>(())
/// ```
pub fn read(path: &Path, bytes: &[u8]) -> Result<Mesh, LoadError> {
    model(path, Cursor::new(bytes)).map_err(|fault| fault.of(path))
}

/// The model in a file of that name.
fn model(path: &Path, mut input: impl BufRead + Seek) -> Result<Mesh, Fault> {
    let size = input.seek(SeekFrom::End(0))?;
    input.rewind()?;
    if size == 0 {
        return fault("the file is empty");
    }
    let mesh = match format(path, &mut input, size)? {
        Format::Obj => obj::read(input)?,
        Format::Ply => ply::read(input)?,
        Format::Stl => stl::read(input, size)?,
    };
    if mesh.triangles.is_empty() {
        return fault("there is no triangle in it; is it really a model?");
    }
    Ok(mesh)
}

/// Opens a regular file.
fn open(path: &Path) -> Result<File, Fault> {
    let metadata = std::fs::metadata(path)?;
    if metadata.is_dir() {
        return fault("is a folder; give a model file (.obj, .ply or .stl)");
    }
    // A pipe or a device may never end.
    if !metadata.is_file() {
        return fault("is not a regular file; give a model file (.obj, .ply or .stl)");
    }
    Ok(File::open(path)?)
}

enum Format {
    Obj,
    Ply,
    Stl,
}

/// The format by the name's ending or, failing that, by the file's beginning.
fn format(path: &Path, input: &mut (impl Read + Seek), size: u64) -> Result<Format, Fault> {
    let extension = path.extension().unwrap_or_default().to_ascii_lowercase();
    match extension.to_str() {
        Some("obj") => return Ok(Format::Obj),
        Some("ply") => return Ok(Format::Ply),
        Some("stl") => return Ok(Format::Stl),
        _ => {}
    }
    let mut start = Vec::new();
    input.by_ref().take(0x1_0000).read_to_end(&mut start)?;
    input.rewind()?;
    if start.starts_with(b"ply") {
        Ok(Format::Ply)
    } else if stl::looks_like(&start, size) {
        Ok(Format::Stl)
    } else if obj::looks_like(&start) {
        Ok(Format::Obj)
    } else {
        fault("is neither OBJ nor PLY nor STL; give such a model, or the right ending to its name")
    }
}

/// Takes positions and polygons as a reader finds them, and refuses what no mesh may hold.
#[derive(Default)]
struct Builder {
    mesh: Mesh,
}

impl Builder {
    /// Adds a position.
    fn position(&mut self, position: [f32; 3]) -> Result<(), Fault> {
        if position.iter().any(|x| !x.is_finite()) {
            let [x, y, z] = position;
            return fault(format!(
                "the vertex ({x}, {y}, {z}) is not finite in f32; repair the model or scale it down"
            ));
        }
        if self.mesh.positions.len() >= u32::MAX as usize {
            return fault("more than 4294967295 vertices; cut the model into parts");
        }
        self.mesh.positions.push(position);
        Ok(())
    }

    /// Adds a polygon of at least three corners as a fan; `uvs` is empty or has one per corner.
    fn polygon(&mut self, corners: &[u32], uvs: &[[f32; 2]]) -> Result<(), Fault> {
        if corners.len() < 3 {
            return fault(format!("a face of {} corners; a face needs three", corners.len()));
        }
        let count = self.mesh.positions.len();
        if let Some(corner) = corners.iter().find(|&&corner| corner as usize >= count) {
            return fault(format!(
                "a face names vertex {corner}, but there are {count}, from 0 on"
            ));
        }
        if uvs.as_flattened().iter().any(|x| !x.is_finite()) {
            return fault("a face has a texture coordinate that is not finite in f32");
        }
        let first = self.mesh.triangles.len();
        self.mesh
            .triangles
            .extend((2..corners.len()).map(|i| [corners[0], corners[i - 1], corners[i]]));
        if self.mesh.triangles.len() > u32::MAX as usize {
            return fault("more than 4294967295 triangles; cut the model into parts");
        }

        // Texture coordinates are kept from the first face that has some; what came before has zeros.
        if !uvs.is_empty() || self.mesh.corner_uvs.is_some() {
            let kept = self.mesh.corner_uvs.get_or_insert_with(Vec::new);
            kept.resize(first, [[0.0; 2]; 3]);
            kept.extend((2..uvs.len()).map(|i| [uvs[0], uvs[i - 1], uvs[i]]));
            kept.resize(self.mesh.triangles.len(), [[0.0; 2]; 3]);
        }
        Ok(())
    }
}

/// What is wrong with a file, and in which line where it has lines.
struct Fault {
    line: Option<u64>,
    cause: String,
}

impl Fault {
    /// The same, in that line.
    fn at(self, line: u64) -> Self {
        Self { line: Some(line), ..self }
    }

    /// The same, in that file.
    fn of(self, path: &Path) -> LoadError {
        LoadError { path: path.into(), line: self.line, cause: self.cause }
    }
}

impl From<io::Error> for Fault {
    fn from(error: io::Error) -> Self {
        Self { line: None, cause: format!("cannot read it: {error}") }
    }
}

fn fault<T>(cause: impl Into<String>) -> Result<T, Fault> {
    Err(Fault { line: None, cause: cause.into() })
}

/// A word of a file for an error message: quoted, its control characters escaped, not too long.
fn quote(word: &str) -> String {
    let short: String = word.chars().take(32).collect();
    format!("{short:?}{}", if short.len() < word.len() { "..." } else { "" })
}

/// Why a model could not be read: `file:line: cause`, in one line.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct LoadError {
    /// The file.
    pub path: PathBuf,
    /// The line where it is wrong, counted from 1, in a file of text.
    pub line: Option<u64>,
    /// What is wrong, and what to do where that is not plain.
    pub cause: String,
}

impl fmt::Display for LoadError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}:", self.path.display())?;
        if let Some(line) = self.line {
            write!(f, "{line}:")?;
        }
        write!(f, " {}", self.cause)
    }
}

impl std::error::Error for LoadError {}
