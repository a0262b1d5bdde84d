//! A mesh with its hierarchy, and its triangles where they are asked for.

use std::sync::OnceLock;

use bytemuck::{Pod, Zeroable};
use intertri::{Hit, RayOf, TriangleOf};
use intertri_trace::Solid;
use pyo3::PyResult;

use crate::part::Part;
use crate::scalar::{Mode, Scalar};

/// A mesh with its hierarchy.
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

impl<S: Scalar> Mesh<S> {
    pub(crate) fn new(solid: Solid<S>) -> Self {
        Self { solid, triangles: OnceLock::new() }
    }

    /// Moves the triangles, and tells how worn the tree is.
    pub(crate) fn refit(&mut self, triangles: &[TriangleOf<S>]) -> PyResult<f64> {
        self.triangles = OnceLock::new();
        S::refit(&mut self.solid, triangles)
    }

    /// Where rays cross, in order of t. What counts once, counts among the hits of closed triangles, too; those are
    /// found in batches.
    pub(crate) fn crossings(&self, rays: &[RayOf<S>]) -> PyResult<Part<CrossingRow>> {
        let triangles = self.triangles.get_or_init(|| S::all_triangles(&self.solid));
        let hits = S::all(&self.solid, Mode::Exact, rays, None)?;
        let (mut from, mut counts) = (0, Vec::with_capacity(rays.len()));
        let mut answers = Vec::with_capacity(hits.answers.len());
        for (ray, &count) in rays.iter().zip(&hits.counts) {
            let before = answers.len();
            let of_ray = &hits.answers[from..from + count as usize];
            answers.extend(of_ray.iter().filter_map(|&hit| {
                let leaves = S::crossing(ray, &triangles[hit.triangle as usize])?;
                Some(CrossingRow { hit, leaves: u64::from(leaves) })
            }));
            from += count as usize;
            counts.push((answers.len() - before) as u32);
        }
        Ok(Part { counts, answers })
    }
}
