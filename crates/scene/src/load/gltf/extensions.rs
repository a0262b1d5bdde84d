//! Handles the glTF extensions that affect triangles.

use glam::DMat4;
use gltf::json::accessor::Type;
use gltf::json::{Index, Root, Value, accessor, scene};

use super::accessor::{Accessor, Tables};
use super::transform::of_parts;
use crate::load::error::{Fault, fault, quote};
use crate::load::notes::Notes;

/// Name prefixes of extensions that are supported or do not change a mesh's shape.
const KNOWN: [&str; 28] = [
    INSTANCES,
    VISIBILITY,
    "ADOBE_materials_",
    "CESIUM_primitive_outline",
    "EXT_feature_metadata",
    "EXT_instance_features",
    "EXT_lights_",
    "EXT_mesh_features",
    "EXT_mesh_manifold",
    "EXT_structural_metadata",
    "EXT_texture_",
    "FB_geometry_metadata",
    "KHR_animation_pointer",
    "KHR_audio",
    "KHR_interactivity",
    "KHR_lights_",
    "KHR_materials_",
    "KHR_mesh_quantization",
    "KHR_node_hoverability",
    "KHR_node_selectability",
    "KHR_techniques_webgl",
    "KHR_texture_",
    "KHR_xmp",
    "MSFT_lod",
    "MSFT_packing_",
    "MSFT_texture_",
    "NV_materials_",
    "VRM",
];

/// Compression extensions and what they compress. A file that uses such an extension without
/// requiring it also contains the uncompressed data.
const COMPRESSIONS: [(&str, &str); 3] = [
    ("KHR_draco_mesh_compression", "its meshes are compressed with Draco"),
    ("EXT_meshopt_compression", "its buffers are compressed with meshopt"),
    ("KHR_meshopt_compression", "its buffers are compressed with meshopt"),
];

const INSTANCES: &str = "EXT_mesh_gpu_instancing";
const VISIBILITY: &str = "KHR_node_visibility";

/// The maximum number of names in a note.
const NAMED: usize = 4;

/// Rejects a file that requires an unknown extension. Adds a note about unknown extensions that the
/// file uses but does not require.
pub(super) fn check(root: &Root, notes: &mut Notes) -> Result<(), Fault> {
    let known = |name: &str| KNOWN.iter().any(|known| name.starts_with(known));
    if let Some(unknown) = root.extensions_required.iter().find(|name| !known(name)) {
        let compression = COMPRESSIONS.iter().find(|(name, _)| name == unknown);
        let what =
            compression.map_or("it needs an extension that is not supported", |(_, what)| what);
        return fault(format!("{what} ({}); export the model without it", quote(unknown)));
    }
    let is_unknown = |name: &&String| {
        !known(name) && !COMPRESSIONS.iter().any(|(compression, _)| compression == name)
    };
    let unknown: Vec<&String> = root.extensions_used.iter().filter(is_unknown).collect();
    if !unknown.is_empty() {
        let mut names: Vec<String> = unknown.iter().take(NAMED).map(|name| quote(name)).collect();
        if unknown.len() > NAMED {
            names.push("...".to_owned());
        }
        let names = names.join(", ");
        let what = format!("extensions that may change shapes, ignored ({names})");
        notes.add(what, unknown.len() as u64, None);
    }
    Ok(())
}

/// Returns a node's data for an extension.
fn of<'a>(node: &'a scene::Node, name: &str) -> Option<&'a Value> {
    node.extensions.as_ref()?.others.get(name)
}

/// Returns whether a node is hidden, together with all of its descendants.
pub(super) fn is_hidden(node: &scene::Node) -> bool {
    of(node, VISIBILITY).and_then(|visibility| visibility.get("visible")?.as_bool()) == Some(false)
}

/// The copies of a node's mesh, as specified by `EXT_mesh_gpu_instancing`.
pub(super) struct Copies<'a> {
    pub(super) count: usize,
    places: Option<Accessor<'a>>,
    turns: Option<Accessor<'a>>,
    sizes: Option<Accessor<'a>>,
}

impl Copies<'_> {
    /// Returns the transform from a copy's space to the node's.
    pub(super) fn transform(&self, i: usize) -> DMat4 {
        let row = |table: &Option<Accessor<'_>>, or: f64| {
            table.as_ref().map_or([or; 3], |table| table.row(i))
        };
        let turn = self.turns.as_ref().map_or([0.0, 0.0, 0.0, 1.0], |turns| turns.row(i));
        of_parts(row(&self.sizes, 1.0), turn, row(&self.places, 0.0))
    }
}

/// Returns the copies of a node's mesh, or `None` if there is a single copy, placed by the node
/// alone.
pub(super) fn copies<'a>(
    tables: Tables<'a>,
    node: &scene::Node,
) -> Result<Option<Copies<'a>>, Fault> {
    let Some(attributes) = of(node, INSTANCES) else { return Ok(None) };
    let Some(attributes) = attributes.get("attributes").and_then(Value::as_object) else {
        return fault(format!("{INSTANCES} has no attributes"));
    };
    let table = |name: &str, kind| {
        let Some(value) = attributes.get(name) else { return Ok(None) };
        let index = value.as_u64().and_then(|index| u32::try_from(index).ok());
        let Some(index) = index else {
            return fault(format!("{INSTANCES} has a {name} that is not an accessor"));
        };
        tables.get(Index::<accessor::Accessor>::new(index), ("instances", kind)).map(Some)
    };
    let places = table("TRANSLATION", Type::Vec3)?;
    let turns = table("ROTATION", Type::Vec4)?;
    let sizes = table("SCALE", Type::Vec3)?;
    let counts = [&places, &turns, &sizes].map(|table| table.as_ref().map(|table| table.count));
    let mut counts = counts.into_iter().flatten();
    let Some(count) = counts.next() else { return Ok(None) };
    if counts.any(|other| other != count) {
        return fault(format!("{INSTANCES} has attributes of different lengths"));
    }
    Ok(Some(Copies { count, places, turns, sizes }))
}
