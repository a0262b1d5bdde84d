//! Queries about one ray, compiled in this crate: what is generic would be compiled again by every crate that calls it.

use intertri::internal::exact::Side;
use intertri::{Crossing, Filter, Hit, LeafSlot, Ray, RayId};

use super::single::{All, Closest, Hits, TraversalScratch};
use crate::containment::Containment;
use crate::selection::ActiveSelection;
use crate::tree::{MeshTriangle, Tree};

/// The closest hit.
pub(crate) fn closest(
    tree: &Tree,
    selection: &ActiveSelection<'_>,
    filter: &Filter<'_>,
    ray: &Ray,
    scratch: &mut TraversalScratch,
) -> Option<Hit> {
    let mut hit = filter.level().run(Hits { tree, filter, ray, selection, scratch })?;
    tree.geometries.rename([&mut hit]);
    Some(hit)
}

/// The triangle of the closest hit.
pub(crate) fn closest_triangle(
    tree: &Tree,
    selection: &ActiveSelection<'_>,
    filter: &Filter<'_>,
    ray: &Ray,
    scratch: &mut TraversalScratch,
) -> Option<MeshTriangle> {
    let selection = (selection, RayId(0));
    let closest = Closest::<false> { tree, filter, ray, selection, scratch };
    let (closest, _) = filter.level().run(closest);
    closest.triangle().map(|(position, _)| tree.geometries.name(position))
}

/// Whether anything is hit.
pub(crate) fn any(
    tree: &Tree,
    selection: &ActiveSelection<'_>,
    filter: &Filter<'_>,
    ray: &Ray,
    scratch: &mut TraversalScratch,
) -> bool {
    let selection = (selection, RayId(0));
    let closest = Closest::<true> { tree, filter, ray, selection, scratch };
    let (closest, _) = filter.level().run(closest);
    closest.is_hit()
}

/// Every hit, by t, then by index.
pub(crate) fn all(
    tree: &Tree,
    selection: &ActiveSelection<'_>,
    filter: &Filter<'_>,
    ray: &Ray,
    scratch: &mut TraversalScratch,
) -> Vec<Hit> {
    let hits = in_order(tree, (selection, RayId(0)), filter, ray, scratch);
    let mut hits: Vec<Hit> = hits.into_iter().map(|(hit, _)| hit).collect();
    tree.geometries.rename(&mut hits);
    hits
}

/// Every hit and its side, by t, then by index: the crossings, if the filter's rule is *once*.
pub(crate) fn crossings(
    tree: &Tree,
    selection: &ActiveSelection<'_>,
    filter: &Filter<'_>,
    ray: &Ray,
    scratch: &mut TraversalScratch,
) -> Vec<Crossing> {
    let crossing = |(mut hit, slot): (Hit, LeafSlot)| {
        tree.geometries.rename([&mut hit]);
        Crossing { hit, leaves: leaves(tree, filter, (RayId(0), ray), slot) }
    };
    let hits = in_order(tree, (selection, RayId(0)), filter, ray, scratch);
    hits.into_iter().map(crossing).collect()
}

/// The closest hit and its side: the next crossing, if the filter's rule is *once*.
pub(crate) fn next_crossing(
    tree: &Tree,
    selection: &ActiveSelection<'_>,
    filter: &Filter<'_>,
    ray: &Ray,
    scratch: &mut TraversalScratch,
) -> Option<Crossing> {
    let selection = (selection, RayId(0));
    let closest = Closest::<false> { tree, filter, ray, selection, scratch };
    let (closest, _) = filter.level().run(closest);
    let (_, slot) = closest.triangle()?;
    let mut hit = filter.hit(ray, &closest, |slot| tree.triangle_in(slot))?;
    tree.geometries.rename([&mut hit]);
    Some(Crossing { hit, leaves: leaves(tree, filter, (RayId(0), ray), slot) })
}

/// Where a ray starts that starts on no triangle.
pub(crate) fn winding(
    tree: &Tree,
    filter: &Filter<'_>,
    ray: &Ray,
    scratch: &mut TraversalScratch,
) -> Containment {
    let slots = slots(tree, (&None, RayId(0)), filter, ray, scratch);
    let leaves = slots.into_iter().map(|slot| leaves(tree, filter, (RayId(0), ray), slot));
    leaves.fold(Containment::Outside, Containment::crossed)
}

/// The slots of all triangles that a ray hits, in any order.
pub(crate) fn slots(
    tree: &Tree,
    selection: (&ActiveSelection<'_>, RayId),
    filter: &Filter<'_>,
    ray: &Ray,
    scratch: &mut TraversalScratch,
) -> Vec<LeafSlot> {
    filter.level().run(All { tree, filter, ray, selection, scratch })
}

/// All hits with their slots, by t, then by position.
fn in_order(
    tree: &Tree,
    selection: (&ActiveSelection<'_>, RayId),
    filter: &Filter<'_>,
    ray: &Ray,
    scratch: &mut TraversalScratch,
) -> Vec<(Hit, LeafSlot)> {
    let (resolver, id) = (filter.resolver(), selection.1);
    let hit = |slot| {
        let (triangle, index) = (tree.triangle_in(slot), tree.index_of(slot));
        (resolver.hit_attributes(ray, &triangle, index, (id, slot)), slot)
    };
    let mut hits: Vec<_> =
        slots(tree, selection, filter, ray, scratch).into_iter().map(hit).collect();
    hits.sort_unstable_by(|(a, one), (b, other)| {
        let [at, bt] = [one, other].map(|slot| tree.triangle_in(*slot));
        resolver.first((ray, id), (a, &at, *one), (b, &bt, *other))
    });
    hits
}

/// Whether a ray runs with the normal of a triangle that it crosses.
fn leaves(tree: &Tree, filter: &Filter<'_>, (id, ray): (RayId, &Ray), slot: LeafSlot) -> bool {
    filter.resolver().facing(ray, &tree.triangle_in(slot), (id, slot)) == Some(Side::Leaves)
}
