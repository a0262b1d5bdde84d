//! One ray through the hierarchy, front to back.

use std::marker::PhantomData;

use intertri::lanes::{Lanes, Mask, Simd};
use intertri::{Best, Counts, Mode, PreparedRay, Ray};

use crate::bvh::{Bvh, Leaf};
use crate::node::LEAF;
use crate::slab::{SlabLanes, Slabs, octant};
use crate::stack::{BOTTOM, Kept};

/// What a search does with the triangles on its way.
///
/// A trait and not a closure: its method must be inlined into the walk, or it is compiled without the
/// level's instructions.
pub(crate) trait Visit {
    /// Looks at the triangles of a leaf. Gives the new far end of the search, or `None` to stop.
    fn visit(&mut self, leaf: usize) -> Option<f32>;
}

/// The origin and the direction among the numbers of a ray.
const ORIGIN_AND_DIR: u32 = 0b0111_0111;

/// Visits the leaves whose triangles a ray may hit, roughly front to back. That the nearest of a node's boxes
/// always comes first pays where the closest hit is looked for: fewer leaves are visited before it.
#[inline(always)]
pub(crate) fn walk<S: Simd>(
    bvh: &Bvh,
    ray: &Ray,
    kept: &mut Kept,
    nearest_first: bool,
    visitor: &mut impl Visit,
) {
    // A ray that is not finite hits nothing, nor does one without an interval.
    let numbers = S::F32x8::load(bytemuck::cast_ref::<Ray, [f32; 8]>(ray));
    let finite = numbers.abs().le(S::F32x8::splat(f32::MAX)).bits();
    let can_hit = finite & ORIGIN_AND_DIR == ORIGIN_AND_DIR && ray.t_min < ray.t_max;
    if !can_hit {
        return;
    }

    // What no box can hold is asked of every ray, and a ray that no box can be held against asks
    // everything.
    let slabs = Slabs::new::<S>(ray, bvh.reach);
    let boxed = if slabs.is_some() { bvh.boxed } else { 0 };
    let (mut unboxed, mut next) = (boxed, if boxed > 0 { 0 } else { BOTTOM });
    let octant = octant(ray);
    let lanes = SlabLanes::<S::F32x8>::splat(&slabs.unwrap_or_default(), octant);
    let Kept { stack, trail } = kept;
    let (mut top, mut stack) = (stack.bottom(0), stack.entries());

    let mut far = ray.t_max;
    loop {
        // The next leaf: one without a box, or the next that begins before the best hit.
        let leaf = if unboxed < bvh.leaves.len() {
            unboxed += 1;
            unboxed - 1
        } else {
            loop {
                if next == BOTTOM {
                    next = stack.pop_at_once(&mut top, far);
                    if next == BOTTOM {
                        return;
                    }
                }
                if next & LEAF != 0 {
                    break (std::mem::replace(&mut next, BOTTOM) ^ LEAF) as usize;
                }

                // A node: of its boxes that the ray meets one is next.
                let node = &bvh.nodes[next as usize];
                let (met, near) = lanes.meet(node, ray.t_min, far);
                if !met.any() {
                    next = BOTTOM;
                    continue;
                }
                let first = if nearest_first {
                    stack.push_nearest_first::<S>(&mut top, node, octant, met, near)
                } else {
                    stack.push::<S>(&mut top, node, octant, met, near)
                };
                next = trail.follow(next, first);
            }
        };
        match visitor.visit(leaf) {
            Some(nearer) => far = nearer,
            None => return,
        }
    }
}

/// A search for the closest hit, or for any.
struct Search<'a, M: Mode, S: Simd> {
    bvh: &'a Bvh,
    mode: &'a M,
    ray: PreparedRay<M>,
    best: Best,
    any: bool,
    counts: &'a mut Counts,
    level: PhantomData<S>,
}

impl<M: Mode, S: Simd> Visit for Search<'_, M, S> {
    #[inline(always)]
    fn visit(&mut self, leaf: usize) -> Option<f32> {
        let Self { bvh, mode, ray, best, any, counts, .. } = self;
        let Leaf { pack, indices } = &bvh.leaves[leaf];
        let find = |place| bvh.triangle_in(place);
        mode.closest_in::<S>(ray, pack, indices, 8 * leaf as u32, find, best, counts);
        if *any && best.is_hit() { None } else { Some(best.t_hi()) }
    }
}

/// The closest hit of a ray; with `any`, some hit.
#[inline(always)]
pub(crate) fn closest<M: Mode, S: Simd>(
    bvh: &Bvh,
    mode: &M,
    ray: &Ray,
    any: bool,
    kept: &mut Kept,
    counts: &mut Counts,
) -> Best {
    let (prepared, best) = (mode.prepare_ray(ray), Best::new(ray.t_max));
    let mut search =
        Search { bvh, mode, ray: prepared, best, any, counts, level: PhantomData::<S> };
    walk::<S>(bvh, ray, kept, !any, &mut search);
    search.best
}

/// A search for all hits.
struct All<'a, M: Mode, S: Simd> {
    bvh: &'a Bvh,
    mode: &'a M,
    ray: &'a Ray,
    hits: Vec<(u32, f64)>,
    level: PhantomData<S>,
}

impl<M: Mode, S: Simd> Visit for All<'_, M, S> {
    #[inline(always)]
    fn visit(&mut self, leaf: usize) -> Option<f32> {
        let triangles = &self.bvh.leaves[leaf].pack;
        let hits = self.mode.pack_in::<S, 8>(self.ray, triangles, &mut Counts::default());
        for lane in (0..8).filter(|lane| hits.bits >> lane & 1 != 0) {
            self.hits.push((8 * leaf as u32 + lane, hits.t[lane as usize]));
        }
        Some(self.ray.t_max)
    }
}

/// The places of all hits of a ray with their t, in the order in which the walk finds them.
#[inline(always)]
pub(crate) fn all<M: Mode, S: Simd>(
    bvh: &Bvh,
    mode: &M,
    ray: &Ray,
    kept: &mut Kept,
) -> Vec<(u32, f64)> {
    let level = PhantomData::<S>;
    let mut search = All { bvh, mode, ray, hits: Vec::new(), level };
    walk::<S>(bvh, ray, kept, false, &mut search);
    search.hits
}
