//! The mesh in the making, and the checks that all formats share.

use super::error::{Fault, fault};
use crate::coordinate::Coordinate;
use crate::mesh::Mesh;

/// Adds an entry, if there is memory for it: tables grow with the file.
pub(super) fn push<T>(table: &mut Vec<T>, entry: T) -> Result<(), Fault> {
    table.try_reserve(1)?;
    table.push(entry);
    Ok(())
}

/// A mesh that grows by the vertices and polygons of a file.
#[derive(Default)]
pub(super) struct MeshBuilder<S> {
    pub(super) mesh: Mesh<S>,
}

impl<S: Coordinate> MeshBuilder<S> {
    /// Adds the position of a vertex.
    pub(super) fn position(&mut self, position: [S; 3]) -> Result<(), Fault> {
        if position.iter().any(|x| !x.is_finite()) {
            let [x, y, z] = position;
            return fault(format!(
                "the vertex ({x}, {y}, {z}) is not finite in {}; repair the model or scale it down",
                S::NAME
            ));
        }
        if self.mesh.positions.len() >= u32::MAX as usize {
            return fault("more than 4294967295 vertices; cut the model into parts");
        }
        push(&mut self.mesh.positions, position)
    }

    /// Adds a polygon of at least three corners as a triangle fan. `uvs` is empty or has one per corner.
    pub(super) fn polygon(&mut self, corners: &[u32], uvs: &[[f32; 2]]) -> Result<(), Fault> {
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
        self.mesh.triangles.try_reserve(corners.len() - 2)?;
        self.mesh
            .triangles
            .extend((2..corners.len()).map(|i| [corners[0], corners[i - 1], corners[i]]));
        if self.mesh.triangles.len() > u32::MAX as usize {
            return fault("more than 4294967295 triangles; cut the model into parts");
        }

        // Texture coordinates are kept from the first face that has some; what came before has zeros.
        if !uvs.is_empty() || self.mesh.corner_uvs.is_some() {
            let kept = self.mesh.corner_uvs.get_or_insert_with(Vec::new);
            kept.try_reserve(self.mesh.triangles.len() - kept.len())?;
            kept.resize(first, [[0.0; 2]; 3]);
            kept.extend((2..uvs.len()).map(|i| [uvs[0], uvs[i - 1], uvs[i]]));
            kept.resize(self.mesh.triangles.len(), [[0.0; 2]; 3]);
        }
        Ok(())
    }

    /// Adds a strip: each corner from the third on makes a triangle with the two before it, and every
    /// other triangle is turned, so that all are wound alike. A triangle that names a vertex twice
    /// only leads the strip elsewhere and is left out.
    pub(super) fn strip(&mut self, corners: &[u32], uvs: &[[f32; 2]]) -> Result<(), Fault> {
        for last in 2..corners.len() {
            let turn = last % 2;
            let places = [last - 2 + turn, last - 1 - turn, last];
            let [a, b, c] = places.map(|place| corners[place]);
            if a == b || b == c || c == a {
                continue;
            }
            // A corner out of range has no texture coordinate: the polygon tells of it.
            let uvs = if uvs.len() == corners.len() { &places.map(|i| uvs[i])[..] } else { &[] };
            self.polygon(&[a, b, c], uvs)?;
        }
        Ok(())
    }
}
