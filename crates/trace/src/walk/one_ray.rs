//! Queries for a single ray. They are not generic, so they are compiled once, in this crate,
//! instead of in every crate that calls them.

use std::marker::PhantomData;

use intertri::internal::exact::Side;
use intertri::internal::sort_hits;
use intertri::{ClosestHit, Crossing, Filter, Hit, Hit32, LeafSlot, Ray, RayId};

use super::HitFormat;
use super::single::{All, Closest, Hits, SingleRay};
use crate::containment::Containment;
use crate::tree::{MeshTriangle, Tree};

/// Returns the closest hit.
pub(crate) fn closest(single: SingleRay<'_>) -> Option<Hit> {
    closest_as(single)
}

/// Returns the closest hit, with t, u, and v in f32.
pub(crate) fn closest32(single: SingleRay<'_>) -> Option<Hit32> {
    closest_as(single)
}

#[inline(always)]
fn closest_as<H: HitFormat>(single: SingleRay<'_>) -> Option<H> {
    let SingleRay { tree, filter, .. } = single;
    let mut hit = filter.level().run(Hits(single, PhantomData::<H>))?;
    tree.geometries.rename([&mut hit]);
    Some(hit)
}

/// Returns the triangle of the closest hit.
pub(crate) fn closest_triangle(single: SingleRay<'_>) -> Option<MeshTriangle> {
    let geometries = &single.tree.geometries;
    // Run only the search. Computing t, u, and v would take exact divisions.
    let (position, _) = search::<false>(single).triangle()?;
    Some(geometries.name(position))
}

/// Returns whether the ray hits anything.
pub(crate) fn any(single: SingleRay<'_>) -> bool {
    // Traversal ends at the first certain hit, wherever on the ray the hit is.
    search::<true>(single).is_hit()
}

/// Returns all hits, sorted by t, then by index.
pub(crate) fn all(single: SingleRay<'_>) -> Vec<Hit> {
    let geometries = &single.tree.geometries;
    let mut hits: Vec<Hit> = in_order(single).into_iter().map(|(hit, _)| hit).collect();
    // Rename last, because ties are broken by the position among all triangles.
    geometries.rename(&mut hits);
    hits
}

/// Returns all hits and the sides on which the ray hits, sorted by t, then by index. With
/// `Rule::Once`, these are the crossings.
pub(crate) fn crossings(single: SingleRay<'_>) -> Vec<Crossing> {
    let SingleRay { tree, filter, ray, .. } = single;
    let hits = in_order(single).into_iter();
    hits.map(|(hit, slot)| crossing(tree, filter, ray, hit, slot)).collect()
}

/// Returns the closest hit and the side on which the ray hits. With `Rule::Once`, this is the next
/// crossing.
pub(crate) fn next_crossing(single: SingleRay<'_>) -> Option<Crossing> {
    let SingleRay { tree, filter, ray, .. } = single;
    // Under `Rule::Once`, every hit is a crossing, so the closest hit is the next crossing.
    let closest = search::<false>(single);
    let (_, slot) = closest.triangle()?;
    let hit = filter.hit(ray, &closest, |slot| tree.triangle_in(slot))?;
    Some(crossing(tree, filter, ray, hit, slot))
}

/// Returns the containment of a ray's origin, which must not be on a triangle.
pub(crate) fn winding(single: SingleRay<'_>) -> Containment {
    let SingleRay { tree, filter, ray, .. } = single;
    let slots = filter.level().run(All(single)).into_iter();
    let leaves = slots.map(|slot| leaves(tree, filter, ray, slot));
    // Leaving counts as 1 and entering as -1. The sum is the winding number of the origin, whatever
    // the direction of the ray.
    leaves.fold(Containment::Outside, Containment::crossed)
}

/// Finds the closest hit of a ray or, with `ANY`, any hit.
#[inline(always)]
fn search<const ANY: bool>(single: SingleRay<'_>) -> ClosestHit {
    let (closest, _) = single.filter.level().run(Closest::<ANY>(single));
    closest
}

/// Returns all hits with their slots, sorted by t, then by position.
fn in_order(single: SingleRay<'_>) -> Vec<(Hit, LeafSlot)> {
    let SingleRay { tree, filter, ray, id, .. } = single;
    let resolver = filter.resolver();
    let hit = |slot| {
        let (triangle, index) = (tree.triangle_in(slot), tree.index_of(slot));
        (resolver.hit_attributes(ray, &triangle, index, (id, slot)), slot)
    };
    let mut hits: Vec<_> = filter.level().run(All(single)).into_iter().map(hit).collect();
    sort_hits(
        &mut hits,
        |(hit, _)| hit,
        |&(_, one), &(_, other)| {
            let [a, b] = [one, other].map(|slot| tree.triangle_in(slot));
            resolver.order(ray, [&a, &b], (id, [one, other]))
        },
    );
    hits
}

/// Converts a hit to a crossing, with its triangle's index in its geometry.
fn crossing(tree: &Tree, filter: &Filter<'_>, ray: &Ray, mut hit: Hit, slot: LeafSlot) -> Crossing {
    tree.geometries.rename([&mut hit]);
    Crossing { hit, leaves: leaves(tree, filter, ray, slot) }
}

/// Returns whether a ray points in the direction of the normal of a triangle that it crosses.
fn leaves(tree: &Tree, filter: &Filter<'_>, ray: &Ray, slot: LeafSlot) -> bool {
    // A crossing is a hit under `Rule::Once`, so D is not 0 and its sign determines the side.
    let side = filter.resolver().facing(ray, &tree.triangle_in(slot), (RayId(0), slot));
    side == Some(Side::Leaves)
}
