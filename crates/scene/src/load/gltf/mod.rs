//! Reads glTF 2.0 files, both JSON text and GLB. The `gltf` crate parses the JSON and the
//! container.
//!
//! Nothing else from that crate is used, because its accessor readers, and even its validation, use
//! numbers from the file as indices and panic if an index is out of range. This reader checks every
//! index before using it.

mod accessor;
mod buffers;
mod extensions;
mod nodes;
mod primitive;
mod shared;
mod transform;

use std::io::Read;

use gltf::json::Root;

use self::accessor::Tables;
use self::buffers::Buffers;
use self::primitive::Primitives;
use self::shared::SharedMeshes;
use super::error::{Fault, fault, quote};
use super::file::SiblingFiles;
use super::notes::Notes;
use crate::instances::InstancedMesh;

/// The first bytes of a GLB.
const MAGIC: &[u8] = b"glTF";
/// The length of a GLB's header.
const HEADER: usize = 12;

/// Returns whether a file with these first bytes is in glTF format.
pub(super) fn looks_like(start: &[u8]) -> bool {
    start.starts_with(MAGIC) || start.trim_ascii_start().starts_with(b"{")
}

/// The default scene of a file.
pub(super) struct Gltf {
    pub(super) model: InstancedMesh,
    pub(super) notes: Notes,
    /// The number of vertices and triangles that the instances may expand to.
    pub(super) most: u64,
}

/// Reads the default scene. Paths to other files are relative to the model's folder.
pub(super) fn read(
    mut input: impl Read,
    beside: Option<&mut SiblingFiles<'_>>,
) -> Result<Gltf, Fault> {
    let mut bytes = Vec::new();
    input.read_to_end(&mut bytes)?;
    let (json, blob) = split(&bytes)?;
    let root: Root = gltf::json::deserialize::from_slice(&json).map_err(|error| {
        // The message may quote arbitrary text from the file.
        let text: String =
            error.to_string().chars().filter(|c| !c.is_control()).take(120).collect();
        let line = Some(error.line() as u64).filter(|&line| line > 0 && blob.is_none());
        Fault { line, cause: format!("its JSON is not glTF 2.0: {text}") }
    })?;
    let version = &root.asset.version;
    if !version.starts_with("2.") {
        return fault(format!("is glTF {}; only version 2 is read", quote(version)));
    }
    let mut notes = Notes::default();
    extensions::check(&root, &mut notes)?;
    let buffers = Buffers::read(&root, blob.as_deref(), beside)?;
    let tables = Tables { root: &root, buffers: &buffers };
    let most = Primitives::most(tables, bytes.len());
    let mut shared = SharedMeshes::new(Primitives::new(tables, most, notes));
    nodes::walk(&mut shared)?;
    let (model, notes) = shared.finish()?;
    Ok(Gltf { model, notes, most })
}

/// Splits a file into its JSON and, in a GLB, the binary chunk.
fn split(bytes: &[u8]) -> Result<(Chunk<'_>, Option<Chunk<'_>>), Fault> {
    if !bytes.starts_with(MAGIC) {
        return Ok((bytes.into(), None));
    }
    // The crate subtracts the header's size from this length, so the length must not be smaller.
    let length = bytes.get(8..HEADER).and_then(|length| length.try_into().ok());
    let length = length.map(u32::from_le_bytes);
    if length.is_none_or(|length| (length as usize) < HEADER) {
        return fault("the GLB is cut off within its header, or its length is wrong");
    }
    match gltf::Glb::from_slice(bytes) {
        Ok(glb) => Ok((glb.json, glb.bin)),
        Err(error) => fault(format!("the GLB is damaged or cut off: {error}")),
    }
}

type Chunk<'a> = std::borrow::Cow<'a, [u8]>;
