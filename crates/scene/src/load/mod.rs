//! Models from files: Wavefront OBJ, PLY and STL.

mod builder;
mod error;
mod lines;
mod obj;
mod ply;
mod stl;

use std::fs::File;
use std::io::{BufRead, BufReader, Cursor, Read, Seek, SeekFrom};
use std::path::Path;

pub use self::error::LoadError;
use self::error::{Fault, fault};
use crate::mesh::Mesh;

/// Reads a model.
///
/// The format is that of the name's ending (`.obj`, `.ply` or `.stl`, in upper or lower case) and,
/// for any other ending, that which the file's beginning looks like.
///
/// - Polygons become triangle fans in their own order, [`Mesh`] says how. A fan fills a concave polygon
///   wrongly; there is no ear clipping, so that triangle indices follow from the file.
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
