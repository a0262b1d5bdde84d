//! A mesh with its hierarchy, and its triangles where they are asked for.

use std::sync::OnceLock;

use bytemuck::{Pod, Zeroable};
use intertri::internal::exact::{self, Side};
use intertri::{Exact, Hit, RayOf, TriangleOf};
use intertri_trace::{BuildError, Bvh, LoadError, ModeFor, RefitError, Solid};
use pyo3::PyResult;

use crate::part::Part;
use crate::scalar::{Mode, Scalar, no_memory, wrong};
use crate::skip::{Skip, without};

/// A mesh with its hierarchy: a `Solid`, closed or not.
pub(crate) struct Mesh<S: Scalar> {
    pub(crate) solid: Solid<S>,
    triangles: OnceLock<Vec<TriangleOf<S>>>,
}

/// Where a ray crosses, as a row of numpy's array.
#[derive(Clone, Copy, Pod, Zeroable)]
#[repr(C)]
pub(crate) struct CrossingRow {
    hit: Hit,
    leaves: u64,
}

impl<S: Scalar> Mesh<S>
where
    Exact: ModeFor<S>,
{
    pub(crate) fn new(triangles: &[TriangleOf<S>]) -> PyResult<Self> {
        Ok(Self::of(Bvh::new(triangles).map_err(no_memory)?))
    }

    fn of(bvh: Bvh<S>) -> Self {
        Self { solid: Solid::assume_closed_bvh(bvh), triangles: OnceLock::new() }
    }

    /// That of saved bytes, over so many triangles.
    pub(crate) fn from_bytes(bytes: &[u8], triangles: usize) -> PyResult<Self> {
        let mut bvh = Bvh::from_bytes(bytes).map_err(|error| match error {
            LoadError::OutOfMemory => no_memory(error),
            error => wrong(error),
        })?;
        if bvh.geometries() != 1 {
            return Err(wrong(format!("a hierarchy of {} meshes, not of one", bvh.geometries())));
        }
        if bvh.len() != triangles {
            return Err(wrong(format!("a hierarchy of {} triangles, not {triangles}", bvh.len())));
        }
        bvh.set_mask(0, u32::MAX);
        Ok(Self::of(bvh))
    }

    /// A copy, without what was made of it.
    pub(crate) fn try_clone(&self) -> Result<Self, BuildError> {
        Ok(Self::of(self.solid.bvh().try_clone()?))
    }

    /// The triangles, in the order in which they were given.
    fn triangles(&self) -> PyResult<&[TriangleOf<S>]> {
        if let Some(triangles) = self.triangles.get() {
            return Ok(triangles);
        }
        let triangles = self.solid.bvh().try_to_triangles().map_err(no_memory)?;
        Ok(self.triangles.get_or_init(|| triangles))
    }

    /// The mesh with its triangles moved, and how worn the tree is: 1 where nothing has moved. Where memory was
    /// too little, it holds no triangle any more.
    pub(crate) fn refit(self, triangles: &[TriangleOf<S>]) -> (Self, Result<f64, RefitError>) {
        let mut bvh = self.solid.into_bvh();
        let refit = bvh.refit(triangles);
        (Self::of(bvh), refit.map(|refit| refit.ratio()))
    }

    /// Where rays cross, in order of t. What counts once, counts among the hits of closed triangles, too; those are
    /// found in batches.
    pub(crate) fn crossings(
        &self,
        rays: &[RayOf<S>],
        skip: Skip<'_>,
    ) -> PyResult<Part<CrossingRow>> {
        let triangles = self.triangles()?;
        let hits = without(self.solid.bvh(), skip, |bvh| S::all(bvh, Mode::Exact, rays, None))?;
        let mut part = Part::new();
        part.reserve(rays.len(), hits.answers.len()).map_err(no_memory)?;
        for (ray, ends) in rays.iter().zip(hits.offsets.windows(2)) {
            let of_ray = &hits.answers[ends[0] as usize..ends[1] as usize];
            part.answers.extend(of_ray.iter().filter_map(|&hit| {
                let triangle = &triangles[hit.triangle as usize];
                let crosses = if is_inside(&hit) { exact::facing } else { exact::crossing };
                let side = crosses(ray, triangle)?;
                Some(CrossingRow { hit, leaves: u64::from(side == Side::Leaves) })
            }));
            part.offsets.push(part.answers.len() as i64);
        }
        Ok(part)
    }
}

/// Whether a ray surely meets a triangle inside of all edges, where every rule says that it crosses. Bound and proof:
/// `docs/numerics/exact.md`, section 9.
fn is_inside(hit: &Hit) -> bool {
    hit.u > 0.0 && hit.v > 0.0 && hit.u + hit.v < 1.0 - f64::EPSILON
}
