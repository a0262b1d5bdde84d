//! Opens model files.

use std::fs::File;
use std::path::{Path, PathBuf};

use super::error::{Fault, fault};

/// The file extensions of the supported formats.
const ENDINGS: &str = ".obj, .ply, .stl, .gltf or .glb";

/// The files that a model refers to, which are in or below its folder.
pub(super) struct SiblingFiles<'a> {
    /// The folder that contains the files.
    pub(super) folder: &'a Path,
    /// The files that have been read so far.
    pub(super) read: Vec<PathBuf>,
}

/// Opens a regular file.
pub(super) fn open(path: &Path) -> Result<File, Fault> {
    let metadata = std::fs::metadata(path)?;
    if metadata.is_dir() {
        return fault(format!("is a folder; give a model file ({ENDINGS})"));
    }
    // Reading a pipe or a device may never end.
    if !metadata.is_file() {
        return fault(format!("is not a regular file; give a model file ({ENDINGS})"));
    }
    Ok(File::open(path)?)
}
