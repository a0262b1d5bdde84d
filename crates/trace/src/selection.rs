//! Selects which triangles a query considers. Filtering runs out of line, on candidate lanes only,
//! so all queries share the same traversal code and unfiltered queries pay nothing.

use std::fmt;

use intertri::internal::Resolver;
use intertri::internal::exact::Side;
use intertri::simd::Simd;
use intertri::{ClosestHit, Counts, Filter, Hit, LeafSlot, PreparedRay, Ray, RayId, TriangleId};

use crate::tree::{Leaf, MeshTriangle, Tree};
use crate::util::lane_ops::lanes_of;

/// The sides of triangles to consider.
///
/// A ray hits the front of a triangle if its direction opposes the normal. Seen from the front, the
/// corners run counter-clockwise. The sign of the direction along the normal is decided exactly in
/// every mode. If that sign is 0, the ray hits neither side.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Faces {
    /// Consider both sides.
    #[default]
    Both,
    /// Consider only front faces and cull back faces.
    Front,
    /// Consider only back faces and cull front faces.
    Back,
}

/// Determines which triangles the rays of a query consider.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Selection<'a> {
    /// A geometry is considered only if its own mask shares a bit with this mask.
    pub(crate) mask: u32,
    pub(crate) faces: Faces,
    /// Lists of hits whose triangles are skipped: one list per ray, or none.
    pub(crate) skip: &'a [&'a [Hit]],
}

impl Selection<'_> {
    /// Selects all triangles.
    pub(crate) const ALL: Selection<'static> =
        Selection { mask: u32::MAX, faces: Faces::Both, skip: &[] };
}

/// The filter for a traversal, or `None` if all triangles are considered.
pub(crate) type ActiveSelection<'a> = Option<TriangleFilter<'a>>;

/// Decides whether to consider a triangle for a ray, given the ray's index in the query and the
/// triangle's slot.
pub(crate) type Predicate<'a> = &'a (dyn Fn(usize, LeafSlot) -> bool + Sync);

/// A selection, and an optional predicate that triangles must also satisfy.
#[derive(Clone, Copy)]
pub(crate) struct TriangleFilter<'a> {
    selection: Selection<'a>,
    predicate: Option<Predicate<'a>>,
    /// The index of the traversal's first ray in the query.
    first: usize,
}

impl fmt::Debug for TriangleFilter<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.selection.fmt(f)
    }
}

impl<'a> Selection<'a> {
    /// Returns the filter for a traversal, or `None` if all triangles are considered.
    #[inline(always)]
    pub(crate) fn active(self, tree: &Tree) -> ActiveSelection<'a> {
        let all = self.faces == Faces::Both && self.skip.is_empty();
        // If nothing would be filtered out, return `None` to take the path without filtering.
        if all && tree.geometries.all_have(self.mask) {
            None
        } else {
            Some(TriangleFilter { selection: self, predicate: None, first: 0 })
        }
    }

    /// Adds a predicate to the selection.
    pub(crate) fn filtered(self, predicate: Predicate<'a>) -> TriangleFilter<'a> {
        TriangleFilter { selection: self, predicate: Some(predicate), first: 0 }
    }
}

impl TriangleFilter<'_> {
    /// Returns the filter for a range of the query's rays.
    pub(crate) fn part(self, from: usize, to: usize) -> Self {
        let Self { mut selection, first, .. } = self;
        if !selection.skip.is_empty() {
            // Each list belongs to the ray at the same position, so slice the lists like the rays.
            selection.skip = &selection.skip[from..to];
        }
        Self { selection, first: first + from, ..self }
    }

    /// Offers the selected triangles of a leaf to the closest-hit search of a ray. It is a separate
    /// function so that traversal without a selection keeps its registers.
    #[inline(always)]
    fn closest_in<S: Simd>(
        &self,
        tree: &Tree,
        filter: &Filter<'_>,
        ray: &PreparedRay,
        leaf: usize,
        closest: &mut ClosestHit,
        counts: &mut Counts,
    ) {
        S::vectorize(
            #[inline(always)]
            || {
                let Leaf { block, indices } = &tree.leaves[leaf];
                let find = |slot| tree.triangle_in(slot);
                let numbered = (ray.id(), ray.ray());
                let keep = |lanes| self.keep(tree, numbered, leaf, lanes, filter.resolver());
                let first = LeafSlot(8 * leaf as u32);
                filter
                    .closest_among_in::<S>(ray, block, indices, first, find, keep, closest, counts);
            },
        );
    }

    /// Returns the candidate lanes of a leaf that are selected for a ray.
    #[inline(never)]
    pub(crate) fn keep(
        &self,
        tree: &Tree,
        (id, ray): (RayId, &Ray),
        leaf: usize,
        lanes: u32,
        resolver: Resolver<'_>,
    ) -> u32 {
        let number = id.0 as usize;
        let skipped = self.selection.skip.get(number).copied().unwrap_or(&[]);
        let counts = |&lane: &usize| {
            let slot = LeafSlot((8 * leaf + lane) as u32);
            let position = tree.index_of(slot);
            // Run the cheap tests first; the predicate may be slow.
            tree.geometries.mask_of(position) & self.selection.mask != 0
                && !is_among(tree, skipped, position)
                && self.faces_count(resolver, tree, (id, ray), slot)
                && self.predicate.is_none_or(|predicate| predicate(self.first + number, slot))
        };
        lanes_of(lanes).filter(counts).map(|lane| 1 << lane).sum()
    }

    /// Returns whether the side that the ray hits is selected.
    fn faces_count(
        &self,
        resolver: Resolver<'_>,
        tree: &Tree,
        (id, ray): (RayId, &Ray),
        slot: LeafSlot,
    ) -> bool {
        let side = match self.selection.faces {
            Faces::Both => return true,
            Faces::Front => Side::Enters,
            Faces::Back => Side::Leaves,
        };
        resolver.facing(ray, &tree.triangle_in(slot), (id, slot)) == Some(side)
    }
}

/// Returns whether a triangle belongs to one of the given hits.
fn is_among(tree: &Tree, hits: &[Hit], position: TriangleId) -> bool {
    // Hits identify a triangle by geometry and index, whereas leaves use its position among the
    // triangles of all meshes.
    let MeshTriangle { triangle, geometry } = tree.geometries.name(position);
    hits.iter().any(|hit| (hit.geometry, hit.triangle) == (geometry, triangle))
}

/// Offers the selected triangles of a leaf to the closest-hit search of a ray.
#[inline(always)]
pub(crate) fn closest_in_leaf<S: Simd>(
    selection: &ActiveSelection<'_>,
    tree: &Tree,
    filter: &Filter<'_>,
    ray: &PreparedRay,
    leaf: usize,
    closest: &mut ClosestHit,
    counts: &mut Counts,
) {
    match selection {
        None => {
            let Leaf { block, indices } = &tree.leaves[leaf];
            let (find, first) = (|slot| tree.triangle_in(slot), LeafSlot(8 * leaf as u32));
            filter.closest_in::<S>(ray, block, indices, first, find, closest, counts);
        }
        // Pass local counts: counts passed by reference would stay in memory throughout the
        // traversal.
        Some(selection) => {
            let mut some = Counts::default();
            selection.closest_in::<S>(tree, filter, ray, leaf, closest, &mut some);
            *counts += some;
        }
    }
}

/// Returns the candidate lanes of a leaf that are selected.
#[inline(always)]
pub(crate) fn selected(
    selection: &ActiveSelection<'_>,
    tree: &Tree,
    ray: (RayId, &Ray),
    leaf: usize,
    lanes: u32,
    resolver: Resolver<'_>,
) -> u32 {
    match selection {
        None => lanes,
        Some(filter) => filter.keep(tree, ray, leaf, lanes, resolver),
    }
}
