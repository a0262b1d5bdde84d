//! Reads primitives, which are the parts of glTF meshes.

use glam::{DMat4, DVec3};
use gltf::json::accessor::Type;
use gltf::json::mesh::{Mesh, Mode, Primitive, Semantic};
use gltf::json::validation::Checked;
use gltf::json::{Index, accessor};

use super::accessor::{Accessor, Tables};
use super::transform::mirrors;
use crate::load::builder::{MeshBuilder, NO_UV, push, strip};
use crate::load::error::{Fault, fault};
use crate::load::flatten::{REPEATED, REPEATS};
use crate::load::notes::Notes;
use crate::mesh::{self, rounded};

/// A reader for the primitives of meshes.
pub(super) struct Primitives<'a> {
    pub(super) tables: Tables<'a>,
    /// For each mesh, the largest number of morph targets in any of its primitives.
    targets: Vec<usize>,
    /// The number of vertices and triangles that may still be read.
    left: u64,
    /// The mesh under construction.
    builder: MeshBuilder<f64>,
    pub(super) notes: Notes,
}

/// The weights of a mesh's morph targets.
#[derive(Clone, Copy)]
pub(super) struct Weights<'a> {
    /// At most one weight per target. Targets without a weight are not applied.
    pub(super) values: &'a [f32],
    /// Whether the values equal the mesh's default weights.
    pub(super) are_default: bool,
}

/// The way in which a mesh is placed in the scene.
#[derive(Clone, Copy)]
pub(super) enum Placement<'a> {
    /// By instances. The mesh stays in its own space; if the instances mirror the mesh, its
    /// triangles are flipped.
    ByInstances { are_mirrored: bool },
    /// By a skin. `joints` are the joints' transforms; each joint moves a vertex in proportion to
    /// its weight for that vertex. Primitives without joints are placed by their node's
    /// `transform`.
    BySkin { joints: &'a [DMat4], transform: DMat4 },
}

impl<'a> Primitives<'a> {
    /// Creates a reader that may read up to `most` vertices and triangles.
    pub(super) fn new(tables: Tables<'a>, most: u64, notes: Notes) -> Self {
        let targets = |primitive: &Primitive| primitive.targets.as_ref().map_or(0, Vec::len);
        let targets = |mesh: &Mesh| mesh.primitives.iter().map(targets).max().unwrap_or(0);
        let targets = tables.root.meshes.iter().map(targets).collect();
        Self { tables, targets, left: most, builder: MeshBuilder::numbered_from(0), notes }
    }

    /// Returns the number of vertices and triangles that a file of `size` bytes may have. The same
    /// limit applies again when the file's instances are flattened.
    pub(super) fn most(tables: Tables<'_>, size: usize) -> u64 {
        REPEATS + size as u64 + tables.buffers.size() as u64
    }

    /// Returns the weights of a mesh's morph targets: the node's `weights` or, if it has none, the
    /// mesh's defaults.
    pub(super) fn weights(
        &self,
        index: usize,
        weights: Option<&'a [f32]>,
    ) -> Result<Weights<'a>, Fault> {
        let meshes = &self.tables.root.meshes;
        let Some(mesh) = meshes.get(index) else {
            return fault(format!("mesh {index} does not exist; there are {}", meshes.len()));
        };
        let used = |weights: &'a [f32]| &weights[..weights.len().min(self.targets[index])];
        let default = used(mesh.weights.as_deref().unwrap_or_default());
        let Some(values) = weights.map(used) else {
            return Ok(Weights { values: default, are_default: true });
        };
        let bits = |weights: &'a [f32]| weights.iter().map(|weight| weight.to_bits());
        Ok(Weights { values, are_default: bits(values).eq(bits(default)) })
    }

    /// Reads a mesh, applying its morph targets with the given weights.
    pub(super) fn mesh(
        &mut self,
        index: usize,
        weights: &[f32],
        placement: Placement<'_>,
    ) -> Result<mesh::Mesh<f64>, Fault> {
        let Mesh { primitives, .. } = &self.tables.root.meshes[index];
        for (i, primitive) in primitives.iter().enumerate() {
            self.primitive(primitive, weights, placement).map_err(|fault| Fault {
                cause: format!("mesh {index}, primitive {i}: {}", fault.cause),
                ..fault
            })?;
        }
        let builder = std::mem::replace(&mut self.builder, MeshBuilder::numbered_from(0));
        let (mesh, notes) = builder.finish()?;
        self.notes.extend(notes);
        Ok(mesh)
    }

    /// Counts vertices, triangles, instances, or joints against the limit before they are read.
    pub(super) fn spend(&mut self, count: usize) -> Result<(), Fault> {
        match self.left.checked_sub(count as u64) {
            Some(left) => self.left = left,
            None => return fault(REPEATED),
        }
        Ok(())
    }

    fn primitive(
        &mut self,
        primitive: &Primitive,
        weights: &[f32],
        placement: Placement<'_>,
    ) -> Result<(), Fault> {
        self.spend(1)?;
        let mode = match primitive.mode {
            Checked::Valid(mode) => mode,
            Checked::Invalid => return fault("its mode is not defined by glTF"),
        };
        if !matches!(mode, Mode::Triangles | Mode::TriangleStrip | Mode::TriangleFan) {
            return Ok(());
        }
        let tables = self.tables;
        let vertices = Vertices::new(tables, primitive, weights, placement)?;
        let count = vertices.positions.count;
        let uvs = attribute(primitive, Semantic::TexCoords(0));
        let uvs =
            uvs.map(|uvs| tables.get(uvs, ("texture coordinates", Type::Vec2))).transpose()?;
        let indices = primitive.indices.map(|i| tables.get(i, ("indices", Type::Scalar)));
        let indices = indices.transpose()?;
        self.spend(count)?;
        self.spend(vertices.layers() * count)?;
        self.spend(indices.as_ref().map_or(count, |indices| indices.count))?;

        let first = self.builder.vertices() as u32;
        if vertices.lacks_joints {
            let what = "skinned primitives without joints and weights, placed by their nodes";
            self.builder.notes.add(what, 1, None);
        }
        // A skin may mirror only some of the vertices.
        let mut mirrored = Vec::new();
        for vertex in 0..count {
            let (position, transform) = vertices.place(vertex)?;
            self.builder.position(rounded(position))?;
            if !vertices.skin.is_empty() {
                push(&mut mirrored, mirrors(&transform))?;
            }
        }
        let all_mirrored = match placement {
            Placement::ByInstances { are_mirrored } => are_mirrored,
            Placement::BySkin { transform, .. } => mirrors(&transform),
        };
        let first_uv = self.builder.uvs() as u32;
        let uv_count = uvs.as_ref().map_or(0, |uvs| uvs.count.min(count)) as u32;
        // The first row of an image is at v = 0 in glTF, but at v = 1 here.
        for [u, v] in uvs.iter().flat_map(Accessor::rows).take(uv_count as usize) {
            self.builder.uv([u as f32, (1.0 - v) as f32])?;
        }
        let count = count as u32;
        let indices = indices.map_or_else(|| Ok((0..count).collect()), |table| table.indices())?;
        if let Some(index) = indices.iter().find(|&&index| index >= count) {
            return fault(format!(
                "its indices refer to vertex {index}, but there are {count}, numbered from 0"
            ));
        }
        let place = |index: u32| if index < uv_count { first_uv + index } else { NO_UV };
        let add = |mut corners: [u32; 3]| {
            if mirrored.get(corners[0] as usize).copied().unwrap_or(all_mirrored) {
                corners.swap(1, 2);
            }
            let corner_uvs = if uvs.is_some() { &corners.map(place)[..] } else { &[] };
            self.builder.polygon(&corners.map(|corner| first + corner), corner_uvs)
        };
        let over = each_triangle(mode, &indices, add)?;
        if over > 0 {
            let what = "corners that do not form a whole triangle, skipped";
            self.builder.notes.add(what, over as u64, None);
        }
        Ok(())
    }
}

/// Calls `add` for each triangle of a primitive and returns the number of corners left over.
fn each_triangle(
    mode: Mode,
    indices: &[u32],
    mut add: impl FnMut([u32; 3]) -> Result<(), Fault>,
) -> Result<usize, Fault> {
    let lone = if indices.len() < 3 { indices.len() } else { 0 };
    match mode {
        Mode::TriangleStrip => {
            strip(indices).try_for_each(|places| add(places.map(|place| indices[place])))?;
            Ok(lone)
        }
        Mode::TriangleFan => {
            (2..indices.len()).try_for_each(|i| add([indices[0], indices[i - 1], indices[i]]))?;
            Ok(lone)
        }
        _ => {
            let (triangles, over) = indices.as_chunks::<3>();
            triangles.iter().try_for_each(|&corners| add(corners))?;
            Ok(over.len())
        }
    }
}

/// The vertices of a primitive.
struct Vertices<'a> {
    positions: Accessor<'a>,
    /// For each morph target, its weight and the displacements of all vertices.
    morphs: Vec<(f64, Accessor<'a>)>,
    /// For each attribute set, a table of every vertex's four joints and a table of their weights.
    skin: Vec<(Accessor<'a>, Accessor<'a>)>,
    lacks_joints: bool,
    placement: Placement<'a>,
}

impl<'a> Vertices<'a> {
    fn new(
        tables: Tables<'a>,
        primitive: &Primitive,
        weights: &[f32],
        placement: Placement<'a>,
    ) -> Result<Self, Fault> {
        let Some(positions) = attribute(primitive, Semantic::Positions) else {
            return fault("it has no POSITION");
        };
        let positions = tables.get(positions, ("positions", Type::Vec3))?;
        let mut morphs = vec![];
        for (target, &weight) in primitive.targets.iter().flatten().zip(weights) {
            if let (Some(ways), true) = (target.positions, weight != 0.0) {
                morphs.push((weight.into(), tables.get(ways, ("morph targets", Type::Vec3))?));
            }
        }
        let mut skin = vec![];
        let has_joints = matches!(placement, Placement::BySkin { joints: [_, ..], .. });
        if has_joints {
            let set = |i| {
                attribute(primitive, Semantic::Joints(i))
                    .zip(attribute(primitive, Semantic::Weights(i)))
            };
            for (joints, shares) in (0..).map_while(set) {
                let joints = tables.get(joints, ("joints", Type::Vec4))?;
                skin.push((joints, tables.get(shares, ("weights", Type::Vec4))?));
            }
        }
        let lacks_joints = has_joints && skin.is_empty();
        let all = morphs.iter().map(|(_, table)| table);
        if all
            .chain(skin.iter().flat_map(|(a, b)| [a, b]))
            .any(|table| table.count < positions.count)
        {
            return fault("it has fewer morph targets, joints or weights than positions");
        }
        Ok(Self { positions, morphs, skin, lacks_joints, placement })
    }

    /// Returns the number of morph targets and joint sets.
    fn layers(&self) -> usize {
        self.morphs.len() + self.skin.len()
    }

    /// Returns the position of a vertex and, in a skinned mesh, the transform applied to it.
    fn place(&self, vertex: usize) -> Result<(DVec3, DMat4), Fault> {
        let mut position = DVec3::from_array(self.positions.row(vertex));
        for (weight, ways) in &self.morphs {
            position += DVec3::from_array(ways.row(vertex)) * *weight;
        }
        let Placement::BySkin { joints, transform } = self.placement else {
            return Ok((position, DMat4::IDENTITY));
        };
        let transform = if self.skin.is_empty() { transform } else { self.blend(joints, vertex)? };
        Ok((transform.transform_point3(position), transform))
    }

    /// Returns the average of the joints' transforms, weighted by the vertex's weights.
    fn blend(&self, all_joints: &[DMat4], vertex: usize) -> Result<DMat4, Fault> {
        let (mut sum, mut all) = (DMat4::ZERO, 0.0);
        for (joints, shares) in &self.skin {
            for (joint, share) in joints.row::<4>(vertex).into_iter().zip(shares.row::<4>(vertex)) {
                if share == 0.0 {
                    continue;
                }
                let Some(transform) = all_joints.get(joint as usize) else {
                    return fault(format!(
                        "vertex {vertex} refers to joint {joint}, which its skin lacks"
                    ));
                };
                sum += *transform * share;
                all += share;
            }
        }
        // Divide by the sum of the weights, which is 1 only up to rounding. A vertex without joints
        // keeps its bind-pose position.
        Ok(if all > 0.0 { sum * (1.0 / all) } else { DMat4::IDENTITY })
    }
}

/// Returns the accessor of an attribute.
fn attribute(primitive: &Primitive, semantic: Semantic) -> Option<Index<accessor::Accessor>> {
    primitive.attributes.get(&Checked::Valid(semantic)).copied()
}
