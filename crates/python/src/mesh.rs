//! A mesh with its hierarchy, and its triangles where they are asked for.

use std::sync::OnceLock;

use bytemuck::{Pod, Zeroable};
use intertri::internal::exact::{self, Side};
use intertri::{Exact, Hit, RayOf, TriangleOf};
use intertri_trace::{Bvh, ModeFor, Solid};
use pyo3::PyResult;

use crate::part::Part;
use crate::scalar::{Mode, Scalar, no_memory, wrong};

/// A mesh with its hierarchy: a `Solid`, closed or not.
#[derive(Clone)]
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
        let solid = Solid::assume_closed(triangles).map_err(no_memory)?;
        Ok(Self { solid, triangles: OnceLock::new() })
    }

    /// That of saved bytes, over so many triangles.
    pub(crate) fn from_bytes(bytes: &[u8], triangles: usize) -> PyResult<Self> {
        let bvh = Bvh::from_bytes(bytes).map_err(wrong)?;
        if bvh.len() != triangles {
            return Err(wrong(format!("a hierarchy of {} triangles, not {triangles}", bvh.len())));
        }
        Ok(Self { solid: Solid::assume_closed_bvh(bvh), triangles: OnceLock::new() })
    }

    /// Moves the triangles, and tells how worn the tree is: 1 where nothing has moved.
    pub(crate) fn refit(&mut self, triangles: &[TriangleOf<S>]) -> PyResult<f64> {
        let none = Self::new(&[])?;
        let mut bvh = std::mem::replace(self, none).solid.into_bvh();
        let refit = bvh.refit(triangles);
        self.solid = Solid::assume_closed_bvh(bvh);
        refit.map(|refit| refit.ratio()).map_err(wrong)
    }

    /// Where rays cross, in order of t. What counts once, counts among the hits of closed triangles, too; those are
    /// found in batches.
    pub(crate) fn crossings(&self, rays: &[RayOf<S>]) -> PyResult<Part<CrossingRow>> {
        let triangles = self.triangles.get_or_init(|| self.solid.bvh().to_triangles());
        let hits = S::all(self.solid.bvh(), Mode::Exact, rays, None)?;
        let (mut from, mut counts) = (0, Vec::with_capacity(rays.len()));
        let mut answers = Vec::with_capacity(hits.answers.len());
        for (ray, &count) in rays.iter().zip(&hits.counts) {
            let before = answers.len();
            let of_ray = &hits.answers[from..from + count as usize];
            answers.extend(of_ray.iter().filter_map(|&hit| {
                let side = exact::crossing(ray, &triangles[hit.triangle as usize])?;
                Some(CrossingRow { hit, leaves: u64::from(side == Side::Leaves) })
            }));
            from += count as usize;
            counts.push((answers.len() - before) as u32);
        }
        Ok(Part { counts, answers })
    }
}
