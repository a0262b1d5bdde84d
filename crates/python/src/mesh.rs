//! A mesh with its hierarchy, as the Python classes query it.

use std::sync::OnceLock;

use bytemuck::{Pod, Zeroable};
use intertri::{Crossing, Hit, Mode, RayOf, TriangleOf};
use intertri_trace::{BuildError, Bvh, LoadError, RefitError, Solid};
use pyo3::PyResult;

use crate::part::Part;
use crate::scalar::{Scalar, no_memory, wrong};
use crate::skip::{Skip, without};

/// A mesh with its hierarchy, stored as a `Solid` whether or not it is closed.
pub(crate) struct Mesh<S: Scalar> {
    pub(crate) solid: Solid<S>,
    /// The same solid with its boundary, computed on first use.
    soup: OnceLock<Solid<S>>,
}

/// A crossing, as a row of a numpy array.
#[derive(Clone, Copy, Pod, Zeroable)]
#[repr(C)]
pub(crate) struct CrossingRow {
    hit: Hit,
    leaves: u64,
}

impl<S: Scalar> Mesh<S> {
    pub(crate) fn new(triangles: &[TriangleOf<S>]) -> PyResult<Self> {
        Ok(Self::of(Bvh::new(triangles).map_err(no_memory)?))
    }

    fn of(bvh: Bvh<S>) -> Self {
        Self { solid: Solid::assume_closed_bvh(bvh), soup: OnceLock::new() }
    }

    /// Returns the solid that is assumed to be closed, or the same solid with its boundary.
    pub(crate) fn solid(&self, assume_closed: bool) -> PyResult<&Solid<S>> {
        if assume_closed {
            return Ok(&self.solid);
        }
        if self.soup.get().is_none() {
            // Another thread may have computed the boundary in the meantime, with the same result.
            _ = self.soup.set(self.solid.with_boundary().map_err(no_memory)?);
        }
        Ok(self.soup.get().unwrap_or(&self.solid))
    }

    /// Loads a hierarchy from saved bytes, which must contain the given number of triangles.
    pub(crate) fn from_bytes(bytes: &[u8], triangles: usize) -> PyResult<Self> {
        let mut bvh = Bvh::from_bytes(bytes).map_err(|error| match error {
            LoadError::OutOfMemory => no_memory(error),
            error => wrong(error),
        })?;
        if bvh.geometries() != 1 {
            return Err(wrong(format!("its tree has {} meshes instead of one", bvh.geometries())));
        }
        if bvh.len() != triangles {
            return Err(wrong(format!("its tree has {} triangles, not {triangles}", bvh.len())));
        }
        bvh.set_mask(0, u32::MAX);
        Ok(Self::of(bvh))
    }

    /// Copies the mesh, without derived data.
    pub(crate) fn try_clone(&self) -> Result<Self, BuildError> {
        Ok(Self::of(self.solid.bvh().try_clone()?))
    }

    /// Moves the triangles. Returns the mesh and the estimated slowdown of rays compared with a new
    /// tree, as a factor. The factor is 1 if no triangle has moved. If memory runs out, the
    /// returned mesh contains no triangles.
    pub(crate) fn refit(self, triangles: &[TriangleOf<S>]) -> (Self, Result<f64, RefitError>) {
        // Drop the solid with its boundary, which would otherwise share the hierarchy.
        drop(self.soup);
        let mut bvh = self.solid.into_bvh();
        let refit = bvh.refit(triangles);
        (Self::of(bvh), refit.map(|refit| refit.ratio()))
    }

    /// Returns the crossings of rays, in order of t.
    pub(crate) fn crossings(
        &self,
        rays: &[RayOf<S>],
        skip: Skip<'_>,
    ) -> PyResult<Part<CrossingRow>> {
        let lists = without(self.solid.bvh(), Mode::exact(), skip, |query| {
            query.crossings_batch(rays, None).map_err(no_memory)
        })?;
        let row = |&Crossing { hit, leaves }: &Crossing| CrossingRow { hit, leaves: leaves.into() };
        let mut rows = Vec::new();
        rows.try_reserve_exact(lists.items.len()).map_err(no_memory)?;
        rows.extend(lists.items.iter().map(row));
        Ok(Part { offsets: lists.offsets, answers: rows })
    }
}
