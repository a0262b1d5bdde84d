//! Single rays: the closest hit, any hit, or all hits of one ray.

mod child_predictor;
mod on_surface;
mod queries;
mod slab;
mod stack;
mod traverse;

pub(crate) use on_surface::is_held;
pub(crate) use queries::{All, Closest, Hits, SingleRay};
pub(crate) use slab::{PackedSlabs, SlabLanes, Slabs, octant};
pub(crate) use stack::{BOTTOM, LentScratch, Stack, TraversalScratch};
pub(crate) use traverse::{Visit, Walk};
