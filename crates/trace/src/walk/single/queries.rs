//! Finds the closest hit, any hit, or all hits of one ray.

use std::marker::PhantomData;

use crate::util::lane_ops::lanes_of;
use intertri::simd::{Simd, WithSimd};
use intertri::{ClosestHit, Counts, Filter, LeafSlot, PreparedRay, Ray, RayId};

use super::stack::TraversalScratch;
use super::traverse::{Visit, traverse};
use crate::selection::{ActiveSelection, closest_in_leaf, selected};
use crate::tree::Tree;
use crate::walk::HitFormat;

/// A single ray and the data needed to trace it.
pub(crate) struct SingleRay<'a> {
    pub(crate) tree: &'a Tree,
    /// The filter. It is passed by reference because it is larger than the parts that traversal
    /// reads.
    pub(crate) filter: &'a Filter<'a>,
    pub(crate) ray: &'a Ray,
    /// The ray's index in its query.
    pub(crate) id: RayId,
    /// The filter that selects which triangles to consider.
    pub(crate) selection: &'a ActiveSelection<'a>,
    pub(crate) scratch: &'a mut TraversalScratch,
}

/// Finds the closest hit of a ray or, with `ANY`, any hit.
pub(crate) struct Closest<'a, const ANY: bool>(pub(crate) SingleRay<'a>);

impl<const ANY: bool> WithSimd for Closest<'_, ANY> {
    type Output = (ClosestHit, Counts);

    #[inline(always)]
    fn run<S: Simd>(self) -> Self::Output {
        let SingleRay { tree, filter, ray, id, selection, scratch } = self.0;
        let mut visitor = VisitClosest::<S, ANY> {
            tree,
            filter,
            ray: filter.prepare_numbered(ray, id),
            selection,
            closest: filter.no_hit(ray),
            counts: Counts::default(),
            level: PhantomData,
        };
        traverse::<S>(tree, (ray, filter.resolver()), scratch, !ANY, &mut visitor);
        (visitor.closest, visitor.counts)
    }
}

/// Finds the closest hit of a ray, with its t and weights in the format H.
pub(crate) struct Hits<'a, H>(pub(crate) SingleRay<'a>, pub(crate) PhantomData<H>);

impl<H: HitFormat> WithSimd for Hits<'_, H> {
    type Output = Option<H>;

    #[inline(always)]
    fn run<S: Simd>(self) -> Option<H> {
        let SingleRay { tree, filter, ray, id, .. } = self.0;
        let (closest, _) = Closest::<false>(self.0).run::<S>();
        let (_, slot) = closest.triangle()?;
        Some(H::met_alone(tree, filter.resolver(), ray, (id, slot)))
    }
}

struct VisitClosest<'a, S: Simd, const ANY: bool> {
    tree: &'a Tree,
    filter: &'a Filter<'a>,
    ray: PreparedRay,
    selection: &'a ActiveSelection<'a>,
    closest: ClosestHit,
    counts: Counts,
    level: PhantomData<S>,
}

impl<S: Simd, const ANY: bool> Visit for VisitClosest<'_, S, ANY> {
    #[inline(always)]
    fn visit(&mut self, leaf: usize) -> Option<f32> {
        let Self { tree, filter, ray, selection, closest, counts, .. } = self;
        closest_in_leaf::<S>(selection, tree, filter, ray, leaf, closest, counts);
        // In an any-hit query, the first hit ends the traversal. Otherwise, nothing beyond the best
        // hit matters.
        if ANY && closest.is_hit() { None } else { Some(closest.t_hi()) }
    }
}

/// Collects the slots of all triangles that a ray hits, in the order in which they are found.
pub(crate) struct All<'a>(pub(crate) SingleRay<'a>);

impl WithSimd for All<'_> {
    type Output = Vec<LeafSlot>;

    #[inline(always)]
    fn run<S: Simd>(self) -> Vec<LeafSlot> {
        let SingleRay { tree, filter, ray, id, selection, scratch } = self.0;
        let prepared = filter.prepare_numbered(ray, id);
        let (slots, level) = (Vec::new(), PhantomData::<S>);
        let mut visitor = VisitAll { tree, filter, ray, prepared, selection, slots, level };
        traverse::<S>(tree, (ray, filter.resolver()), scratch, false, &mut visitor);
        visitor.slots
    }
}

struct VisitAll<'a, S> {
    tree: &'a Tree,
    filter: &'a Filter<'a>,
    ray: &'a Ray,
    prepared: PreparedRay,
    selection: &'a ActiveSelection<'a>,
    slots: Vec<LeafSlot>,
    level: PhantomData<S>,
}

impl<S: Simd> Visit for VisitAll<'_, S> {
    #[inline(always)]
    fn visit(&mut self, leaf: usize) -> Option<f32> {
        let Self { tree, filter, ray, prepared, selection, .. } = &*self;
        let (block, first, id) = (&tree.leaves[leaf].block, 8 * leaf, prepared.id());
        let counts = &mut Counts::default();
        if let Some(hits) = filter.block_hits_in::<S>(prepared, block, ray.t_max, counts) {
            let resolver = filter.resolver();
            let pair = |lane| (**ray, block.triangle(lane), (id, LeafSlot((first + lane) as u32)));
            let met = match hits.undecided {
                0 => hits.sure,
                undecided => hits.sure | resolver.meeting(undecided, pair),
            };
            let lanes = selected(selection, tree, (id, *ray), leaf, met, resolver);
            self.slots.extend(lanes_of(lanes).map(|lane| LeafSlot((first + lane) as u32)));
        }
        // Every hit counts, so the far end does not change.
        Some(self.ray.t_max)
    }
}
