//! Primitives: what a mesh of a glTF is made of.

use glam::{DMat4, DVec3};
use gltf::json::accessor::Type;
use gltf::json::mesh::{Mode, Primitive, Semantic};
use gltf::json::validation::Checked;
use gltf::json::{Index, Root, accessor};

use super::accessor::Accessor;
use super::buffers::Buffers;
use crate::coordinate::Coordinate;
use crate::load::builder::MeshBuilder;
use crate::load::error::{Fault, fault};
use crate::mesh::rounded;

/// What a file may come to beyond its size, in vertices and triangles: nodes can repeat a mesh, and
/// accessors the same bytes, without end.
const REPEATS: u64 = 1 << 24;

/// The primitives of all meshes, as they are added.
pub(super) struct Primitives<'a, S> {
    root: &'a Root,
    buffers: &'a Buffers<'a>,
    /// How many vertices and triangles may still come.
    left: u64,
    pub(super) builder: MeshBuilder<S>,
}

impl<'a, S: Coordinate> Primitives<'a, S> {
    /// None so far, of a file of that size.
    pub(super) fn new(root: &'a Root, buffers: &'a Buffers<'a>, size: usize) -> Self {
        let left = REPEATS + size as u64 + buffers.size() as u64;
        Self { root, buffers, left, builder: MeshBuilder::default() }
    }

    /// Adds a mesh where `transform` puts it.
    pub(super) fn add(&mut self, mesh: usize, transform: &DMat4) -> Result<(), Fault> {
        let Some(found) = self.root.meshes.get(mesh) else {
            return fault(format!(
                "mesh {mesh} is named, but there are {}",
                self.root.meshes.len()
            ));
        };
        for (i, primitive) in found.primitives.iter().enumerate() {
            self.primitive(primitive, transform).map_err(|fault| Fault {
                cause: format!("mesh {mesh}, primitive {i}: {}", fault.cause),
                ..fault
            })?;
        }
        Ok(())
    }

    /// Counts what is to come.
    fn spend(&mut self, count: usize) -> Result<(), Fault> {
        match self.left.checked_sub(count as u64) {
            Some(left) => self.left = left,
            None => {
                return fault(format!(
                    "the file repeats its meshes to more than {REPEATS} vertices and triangles; \
                     export fewer copies"
                ));
            }
        }
        Ok(())
    }

    fn primitive(&mut self, primitive: &Primitive, transform: &DMat4) -> Result<(), Fault> {
        self.spend(1)?;
        let mode = match primitive.mode {
            Checked::Valid(mode) => mode,
            Checked::Invalid => return fault("its mode is none that glTF knows"),
        };
        if !matches!(mode, Mode::Triangles | Mode::TriangleStrip | Mode::TriangleFan) {
            return Ok(());
        }
        let Some(positions) = attribute(primitive, Semantic::Positions) else {
            return fault("it has no POSITION");
        };
        let (root, buffers) = (self.root, self.buffers);
        let table = |index: Index<accessor::Accessor>, what| {
            Accessor::new(root, buffers, index.value(), what)
        };
        let positions = table(positions, ("positions", Type::Vec3))?;
        let uvs = attribute(primitive, Semantic::TexCoords(0));
        let uvs = uvs.map(|uvs| table(uvs, ("texture coordinates", Type::Vec2))).transpose()?;
        let indices = primitive.indices.map(|i| table(i, ("indices", Type::Scalar))).transpose()?;
        self.spend(positions.count)?;
        self.spend(indices.as_ref().map_or(positions.count, |indices| indices.count))?;

        let first = self.builder.mesh.positions.len() as u32;
        for position in positions.rows() {
            self.builder
                .position(rounded(transform.transform_point3(DVec3::from_array(position))))?;
        }
        let count = positions.count as u32;
        let indices = indices.map_or_else(|| Ok((0..count).collect()), |table| table.indices())?;
        if let Some(index) = indices.iter().find(|&&index| index >= count) {
            return fault(format!(
                "its indices name vertex {index}, but there are {count}, from 0 on"
            ));
        }
        let corners: Vec<u32> = indices.iter().map(|index| first + index).collect();
        // The first row of a glTF's image is at 0, and at 1 here.
        let uvs = uvs.map(|uvs| uvs.rows().map(|[u, v]| [u as f32, (1.0 - v) as f32]).collect());
        let uvs: Vec<[f32; 2]> = uvs.unwrap_or_default();
        let uvs: Vec<[f32; 2]> =
            indices.iter().filter_map(|&index| uvs.get(index as usize).copied()).collect();
        self.triangles(mode, &corners, &uvs)
    }

    /// Adds triangles by their corners. Corners that stand over make none, says the format.
    fn triangles(&mut self, mode: Mode, corners: &[u32], uvs: &[[f32; 2]]) -> Result<(), Fault> {
        let uvs = if uvs.len() == corners.len() { uvs } else { &[] };
        match mode {
            Mode::TriangleStrip => self.builder.strip(corners, uvs),
            Mode::TriangleFan if corners.len() >= 3 => self.builder.polygon(corners, uvs),
            Mode::TriangleFan => Ok(()),
            _ => {
                for (i, corners) in corners.chunks_exact(3).enumerate() {
                    self.builder.polygon(corners, uvs.get(3 * i..3 * i + 3).unwrap_or_default())?;
                }
                Ok(())
            }
        }
    }
}

/// The accessor of an attribute.
fn attribute(primitive: &Primitive, semantic: Semantic) -> Option<Index<accessor::Accessor>> {
    primitive.attributes.get(&Checked::Valid(semantic)).copied()
}
