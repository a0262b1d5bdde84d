//! Which triangles a query considers. Filtering runs out of line, on candidate lanes only, so traversal is
//! shared and unfiltered queries pay nothing.

use std::fmt;

use intertri::internal::Resolver;
use intertri::internal::exact::Side;
use intertri::simd::Simd;
use intertri::{ClosestHit, Counts, Filter, Hit, LeafSlot, PreparedRay, Ray, RayId, TriangleId};

use crate::tree::{Leaf, MeshTriangle, Tree};
use crate::util::lane_ops::lanes_of;

/// Which sides of triangles to consider.
///
/// A ray meets a triangle's front if it runs against the normal: seen from there, the corners run
/// counter-clockwise. The sign of the direction along the normal decides, exactly and in every mode. If it is
/// 0, the ray meets neither side.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Faces {
    /// Either side.
    #[default]
    Both,
    /// Only the front: back faces are culled.
    Front,
    /// Only the back: front faces are culled.
    Back,
}

/// The triangles to consider for the rays of a query.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Selection<'a> {
    /// A geometry is considered if this and its own mask have a bit in common.
    pub(crate) mask: u32,
    pub(crate) faces: Faces,
    /// The hits whose triangles each ray skips: one list per ray, or none.
    pub(crate) skip: &'a [&'a [Hit]],
}

impl Selection<'_> {
    /// All triangles.
    pub(crate) const ALL: Selection<'static> =
        Selection { mask: u32::MAX, faces: Faces::Both, skip: &[] };
}

/// The filter of a traversal; `None` if all triangles are considered.
pub(crate) type ActiveSelection<'a> = Option<TriangleFilter<'a>>;

/// Whether to consider a triangle for a ray, given the ray's index in the query and the triangle's slot.
pub(crate) type Predicate<'a> = &'a (dyn Fn(usize, LeafSlot) -> bool + Sync);

/// A selection, and a predicate that triangles must also satisfy.
#[derive(Clone, Copy)]
pub(crate) struct TriangleFilter<'a> {
    selection: Selection<'a>,
    predicate: Option<Predicate<'a>>,
    /// The index in the query of the traversal's first ray.
    first: usize,
}

impl fmt::Debug for TriangleFilter<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.selection.fmt(f)
    }
}

impl<'a> Selection<'a> {
    /// The filter of a traversal, if it needs one.
    #[inline(always)]
    pub(crate) fn active(self, tree: &Tree) -> ActiveSelection<'a> {
        let all = self.faces == Faces::Both && self.skip.is_empty();
        // If nothing would be filtered out, `None` takes the path without filtering.
        if all && tree.geometries.all_have(self.mask) {
            None
        } else {
            Some(TriangleFilter { selection: self, predicate: None, first: 0 })
        }
    }

    /// The selection with a predicate.
    pub(crate) fn filtered(self, predicate: Predicate<'a>) -> TriangleFilter<'a> {
        TriangleFilter { selection: self, predicate: Some(predicate), first: 0 }
    }
}

impl TriangleFilter<'_> {
    /// The filter for some of the query's rays.
    pub(crate) fn part(self, from: usize, to: usize) -> Self {
        let Self { mut selection, first, .. } = self;
        if !selection.skip.is_empty() {
            // The lists belong to rays by position, so they are split like the rays.
            selection.skip = &selection.skip[from..to];
        }
        Self { selection, first: first + from, ..self }
    }

    /// Offers the selected triangles of a leaf to the closest hit of a ray. A separate function, so that
    /// traversal without a selection keeps its registers.
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

    /// The candidate lanes of a leaf that are selected for a ray.
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
            // Cheap tests first; the predicate may be slow.
            tree.geometries.mask_of(position) & self.selection.mask != 0
                && !is_among(tree, skipped, position)
                && self.faces_count(resolver, tree, (id, ray), slot)
                && self.predicate.is_none_or(|predicate| predicate(self.first + number, slot))
        };
        lanes_of(lanes).filter(counts).map(|lane| 1 << lane).sum()
    }

    /// Whether the side that the ray meets is selected.
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

/// Whether a triangle is one of the given hits.
fn is_among(tree: &Tree, hits: &[Hit], position: TriangleId) -> bool {
    // Hits identify a triangle by its geometry, leaves by its position among all.
    let MeshTriangle { triangle, geometry } = tree.geometries.name(position);
    hits.iter().any(|hit| (hit.geometry, hit.triangle) == (geometry, triangle))
}

/// Offers the selected triangles of a leaf to the closest hit of a ray.
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
        // Counts passed by reference would be kept in memory throughout the traversal.
        Some(selection) => {
            let mut some = Counts::default();
            selection.closest_in::<S>(tree, filter, ray, leaf, closest, &mut some);
            *counts += some;
        }
    }
}

/// The candidate lanes of a leaf that are selected.
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
