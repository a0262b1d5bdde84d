//! Collects the meshes of a file and their instances, reading shared meshes only once.

use std::collections::HashMap;

use glam::DMat4;

use super::primitive::{Placement, Primitives, Weights};
use super::transform::mirrors;
use crate::instances::{Instance, InstancedMesh};
use crate::load::builder::push;
use crate::load::error::{Fault, fault};
use crate::load::notes::Notes;
use crate::mesh::Mesh;

/// An instance counts toward the limit as this many vertices or triangles, which take about as much
/// memory.
const INSTANCE: usize = 7;

/// Collects meshes and instances.
pub(super) struct SharedMeshes<'a> {
    pub(super) primitives: Primitives<'a>,
    model: InstancedMesh,
    /// The index of each mesh read so far, or `None` for a mesh without triangles.
    known: HashMap<Key, Option<u32>>,
}

/// Identifies uses of a mesh that can share its triangles. A key contains the mesh's index, the
/// bits of the morph weights (`None` for the mesh's default weights), and whether a mirroring
/// transform flips the triangles.
type Key = (usize, Option<Vec<u32>>, bool);

impl<'a> SharedMeshes<'a> {
    pub(super) fn new(primitives: Primitives<'a>) -> Self {
        Self { primitives, model: InstancedMesh::default(), known: HashMap::new() }
    }

    /// Adds a node's instances of a mesh, reading the mesh if necessary.
    pub(super) fn add(
        &mut self,
        index: usize,
        weights: Weights<'_>,
        transforms: impl IntoIterator<Item = DMat4>,
    ) -> Result<(), Fault> {
        // Look up the mesh only once per node, with and without mirroring: the time is proportional
        // to the number of weights, and a small file can have many weights and many instances.
        let mut looked_up = [None; 2];
        for transform in transforms {
            self.primitives.spend(INSTANCE)?;
            if !transform.is_finite() {
                return fault(format!(
                    "a node or an instance places mesh {index} at coordinates that are not finite; repair the model"
                ));
            }
            let are_mirrored = mirrors(&transform);
            let mesh = &mut looked_up[usize::from(are_mirrored)];
            let mesh = match *mesh {
                Some(mesh) => mesh,
                None => *mesh.insert(self.mesh(index, weights, are_mirrored)?),
            };
            self.push_instance(mesh, transform)?;
        }
        Ok(())
    }

    /// Returns the number of a mesh, reading it at its first use, or `None` if it has no triangles.
    fn mesh(
        &mut self,
        index: usize,
        weights: Weights<'_>,
        are_mirrored: bool,
    ) -> Result<Option<u32>, Fault> {
        let bits = || weights.values.iter().map(|weight| weight.to_bits()).collect();
        let key = (index, (!weights.are_default).then(bits), are_mirrored);
        if let Some(&mesh) = self.known.get(&key) {
            return Ok(mesh);
        }
        let placement = Placement::ByInstances { are_mirrored };
        let mesh = self.primitives.mesh(index, weights.values, placement)?;
        let mesh = self.push_mesh(mesh)?;
        self.known.insert(key, mesh);
        Ok(mesh)
    }

    /// Adds a skinned mesh, which is placed by its joints.
    pub(super) fn add_skinned(
        &mut self,
        index: usize,
        weights: &[f32],
        joints: &[DMat4],
        transform: DMat4,
    ) -> Result<(), Fault> {
        let mesh = self.primitives.mesh(index, weights, Placement::BySkin { joints, transform })?;
        let mesh = self.push_mesh(mesh)?;
        self.push_instance(mesh, DMat4::IDENTITY)
    }

    fn push_mesh(&mut self, mesh: Mesh<f64>) -> Result<Option<u32>, Fault> {
        if mesh.triangles.is_empty() {
            return Ok(None);
        }
        let number = self.model.meshes.len() as u32;
        push(&mut self.model.meshes, mesh)?;
        Ok(Some(number))
    }

    fn push_instance(&mut self, mesh: Option<u32>, transform: DMat4) -> Result<(), Fault> {
        let Some(mesh) = mesh else { return Ok(()) };
        let columns = transform.to_cols_array_2d();
        let matrix = std::array::from_fn(|i| columns[i % 4][i / 4]);
        push(&mut self.model.instances, Instance { mesh, matrix })
    }

    /// Returns the meshes, instances, and notes, once the whole file has been read.
    pub(super) fn finish(mut self) -> Result<(InstancedMesh, Notes), Fault> {
        // If only some meshes have texture coordinates, give the others zeros.
        let meshes = &mut self.model.meshes;
        if meshes.iter().any(|mesh| mesh.corner_uvs.is_some()) {
            for mesh in meshes {
                let uvs = mesh.corner_uvs.get_or_insert_with(Vec::new);
                uvs.try_reserve(mesh.triangles.len() - uvs.len())?;
                uvs.resize(mesh.triangles.len(), [[0.0; 2]; 3]);
            }
        }
        Ok((self.model, self.primitives.notes))
    }
}
