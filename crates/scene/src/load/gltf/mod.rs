//! glTF 2.0, as text and as GLB: the crate `gltf` for its JSON and its container.
//!
//! Nothing of the crate beyond those two is used. Its readers of accessors, and its validation too,
//! index by what a file says and panic where that is wrong. Here every number of a file is looked up
//! before it is believed.

mod accessor;
mod buffers;
mod primitive;

use std::io::Read;

use glam::{DMat4, DQuat, DVec3};
use gltf::json::{Index, Root, scene};

use self::buffers::Buffers;
use self::primitive::Primitives;
use super::error::{Fault, fault, quote};
use super::file::Beside;
use crate::coordinate::Coordinate;
use crate::mesh::Mesh;

/// How a GLB begins.
const MAGIC: &[u8] = b"glTF";
/// The bytes of a GLB's header.
const HEADER: usize = 12;

/// Extensions that change nothing of a mesh's shape, by the beginnings of their names.
const HARMLESS: [&str; 6] = [
    "KHR_materials_",
    "KHR_texture_",
    "EXT_texture_",
    "KHR_lights_",
    "KHR_mesh_quantization",
    "MSFT_texture_",
];

/// Whether a file of that beginning is a glTF.
pub(super) fn looks_like(start: &[u8]) -> bool {
    start.starts_with(MAGIC) || start.trim_ascii_start().starts_with(b"{")
}

/// Reads the default scene into one mesh. Its other files, if it has any, are beside it.
pub(super) fn read<S: Coordinate>(
    mut input: impl Read,
    beside: Option<&mut Beside<'_>>,
) -> Result<Mesh<S>, Fault> {
    let mut bytes = Vec::new();
    input.read_to_end(&mut bytes)?;
    let (json, blob) = split(&bytes)?;
    let root: Root = gltf::json::deserialize::from_slice(&json).map_err(|error| {
        // What is quoted of the file may be anything.
        let text: String =
            error.to_string().chars().filter(|c| !c.is_control()).take(120).collect();
        let line = Some(error.line() as u64).filter(|&line| line > 0 && blob.is_none());
        Fault { line, cause: format!("its JSON is no glTF 2.0: {text}") }
    })?;
    check(&root)?;
    let buffers = Buffers::read(&root, blob.as_deref(), beside)?;
    let mut primitives = Primitives::new(&root, &buffers, bytes.len());
    walk(&root, &mut primitives)?;
    Ok(primitives.builder.mesh)
}

/// The JSON of a file and, of a GLB, its binary chunk.
fn split(bytes: &[u8]) -> Result<(Chunk<'_>, Option<Chunk<'_>>), Fault> {
    if !bytes.starts_with(MAGIC) {
        return Ok((bytes.into(), None));
    }
    // The crate subtracts the header's size from the length.
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

/// Whether all that the file requires is known here.
fn check(root: &Root) -> Result<(), Fault> {
    let version = &root.asset.version;
    if !version.starts_with("2.") {
        return fault(format!("is glTF {}; only version 2 is read", quote(version)));
    }
    let known = |name: &str| HARMLESS.iter().any(|harmless| name.starts_with(harmless));
    let Some(unknown) = root.extensions_required.iter().find(|name| !known(name)) else {
        return Ok(());
    };
    let what = match unknown.as_str() {
        "KHR_draco_mesh_compression" => "its meshes are compressed by Draco",
        "EXT_meshopt_compression" | "KHR_meshopt_compression" => {
            "its buffers are compressed by meshopt"
        }
        _ => "it needs an extension that is not supported",
    };
    fault(format!("{what} ({}); export the model without that", quote(unknown)))
}

/// Adds the meshes of all nodes, each before its children.
fn walk<S: Coordinate>(root: &Root, primitives: &mut Primitives<'_, S>) -> Result<(), Fault> {
    let mut reached = vec![false; root.nodes.len()];
    let mut next: Vec<(usize, DMat4)> = Vec::new();
    next.extend(roots(root)?.into_iter().rev().map(|node| (node, DMat4::IDENTITY)));
    while let Some((index, above)) = next.pop() {
        let Some(node) = root.nodes.get(index) else {
            return fault(format!("node {index} is named, but there are {}", root.nodes.len()));
        };
        if std::mem::replace(&mut reached[index], true) {
            return fault(format!("node {index} is reached twice; nodes must form a tree"));
        }
        let transform = above * transform(node);
        if let Some(mesh) = node.mesh {
            primitives.add(mesh.value(), &transform)?;
        }
        let children = node.children.iter().flatten().rev();
        next.extend(children.map(|child| (child.value(), transform)));
    }
    Ok(())
}

/// The nodes at the top of the scene; without a scene, all that are nobody's child.
fn roots(root: &Root) -> Result<Vec<usize>, Fault> {
    let index = root.scene.map_or(0, |scene| scene.value());
    match root.scenes.get(index) {
        Some(scene) => Ok(scene.nodes.iter().map(Index::value).collect()),
        None if root.scene.is_some() => {
            fault(format!("scene {index} is named, but there are {}", root.scenes.len()))
        }
        None => {
            let mut top = vec![true; root.nodes.len()];
            for child in root.nodes.iter().filter_map(|node| node.children.as_ref()).flatten() {
                if let Some(top) = top.get_mut(child.value()) {
                    *top = false;
                }
            }
            Ok((0..top.len()).filter(|&node| top[node]).collect())
        }
    }
}

/// From a node's space to that of its parent.
fn transform(node: &scene::Node) -> DMat4 {
    if let Some(matrix) = &node.matrix {
        return DMat4::from_cols_array(&matrix.map(f64::from));
    }
    let vector = |v: Option<[f32; 3]>, or| v.map_or(or, |v| DVec3::from(v.map(f64::from)));
    let rotation = node.rotation.unwrap_or_default().0.map(f64::from);
    // It should have unit length, and has it up to f32.
    let rotation = DQuat::from_array(rotation);
    let length = rotation.length();
    let rotation = if length > 0.0 { rotation / length } else { DQuat::IDENTITY };
    DMat4::from_scale_rotation_translation(
        vector(node.scale, DVec3::ONE),
        rotation,
        vector(node.translation, DVec3::ZERO),
    )
}
