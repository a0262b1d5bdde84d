//! Which triangles count in a query. Filtering runs out of line, on candidate lanes only, so traversal is shared and
//! unfiltered queries pay nothing.

use std::fmt;

use intertri::internal::Resolver;
use intertri::internal::exact::Side;
use intertri::simd::Simd;
use intertri::{ClosestHit, Counts, Filter, Hit, LeafSlot, PreparedRay, Ray, RayId, TriangleId};

use crate::tree::{Leaf, MeshTriangle, Tree};
use crate::util::lane_ops::lanes_of;

/// Which side of a triangle counts.
///
/// A ray meets a triangle from its front where it runs against the normal: seen from there, the corners run
/// counter-clockwise. The sign of the direction along the normal decides, exactly and in every mode. If it is 0, the ray
/// meets neither side.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Faces {
    /// Either side.
    #[default]
    Both,
    /// The front alone: back faces are culled.
    Front,
    /// The back alone: front faces are culled.
    Back,
}

/// Which triangles count for the rays of a query.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Selection<'a> {
    /// A geometry counts if this and its own mask have a bit in common.
    pub(crate) mask: u32,
    pub(crate) faces: Faces,
    /// The hits whose triangles each ray skips: a list a ray, or none.
    pub(crate) skip: &'a [&'a [Hit]],
}

impl Selection<'_> {
    /// All triangles.
    pub(crate) const ALL: Selection<'static> =
        Selection { mask: u32::MAX, faces: Faces::Both, skip: &[] };
}

/// The filter of a traversal; `None` if all triangles count.
pub(crate) type ActiveSelection<'a> = Option<TriangleFilter<'a>>;

/// Whether a triangle counts for a ray, by the ray's number in the query and the triangle's slot.
pub(crate) type Predicate<'a> = &'a (dyn Fn(usize, LeafSlot) -> bool + Sync);

/// A selection, and a predicate that triangles also have to satisfy.
#[derive(Clone, Copy)]
pub(crate) struct TriangleFilter<'a> {
    selection: Selection<'a>,
    predicate: Option<Predicate<'a>>,
    /// The number in the query of the traversal's first ray.
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
        // Where nothing would be filtered out, `None` takes the path without filtering.
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
            // The lists belong to rays by position, so they are cut as the rays are.
            selection.skip = &selection.skip[from..to];
        }
        Self { selection, first: first + from, ..self }
    }

    /// Offers the triangles of a leaf that count to the closest hit of a ray. In a frame of its own, so that
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

    /// The candidate lanes of a leaf that count for a ray.
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
            // The cheap tests first; the predicate may be slow.
            tree.geometries.mask_of(position) & self.selection.mask != 0
                && !is_among(tree, skipped, position)
                && self.faces_count(resolver, tree, (id, ray), slot)
                && self.predicate.is_none_or(|predicate| predicate(self.first + number, slot))
        };
        lanes_of(lanes).filter(counts).map(|lane| 1 << lane).sum()
    }

    /// Whether the side from which a ray comes counts.
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

/// Whether a triangle is one of those that were hit.
fn is_among(tree: &Tree, hits: &[Hit], position: TriangleId) -> bool {
    // Hits name a triangle by its geometry, leaves by its position in the whole.
    let MeshTriangle { triangle, geometry } = tree.geometries.name(position);
    hits.iter().any(|hit| (hit.geometry, hit.triangle) == (geometry, triangle))
}

/// Offers the triangles of a leaf, those that count, to the closest hit of a ray.
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
        // Counts passed by reference to a call would live in memory in all of the traversal.
        Some(selection) => {
            let mut some = Counts::default();
            selection.closest_in::<S>(tree, filter, ray, leaf, closest, &mut some);
            *counts += some;
        }
    }
}

/// The candidate lanes of a leaf that count.
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
