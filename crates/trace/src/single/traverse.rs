//! One ray through the hierarchy, front to back.

use intertri::Ray;
use intertri::simd::{Lanes, Mask, Simd};

use super::slab::{SlabLanes, Slabs, octant};
use super::stack::{BOTTOM, Kept};
use crate::tree::{LEAF, Tree};

/// What a query does with the triangles on the way.
///
/// A trait and not a closure: its method must be inlined into the traversal, or it is compiled without the
/// level's instructions.
pub(crate) trait Visit {
    /// Looks at the triangles of a leaf. Gives the new far end of the query, or `None` to stop.
    fn visit(&mut self, leaf: usize) -> Option<f32>;
}

/// The origin and the direction among the numbers of a ray.
const ORIGIN_AND_DIR: u32 = 0b0111_0111;

/// Visits the leaves whose triangles a ray may hit, roughly front to back. That the nearest of a node's boxes
/// always comes first pays where the `closest` hit is looked for: fewer leaves are visited before it. Who looks for
/// another must not bring the far end nearer: nothing on the stack is dropped.
#[inline(always)]
pub(super) fn traverse<S: Simd>(
    bvh: &Tree,
    ray: &Ray,
    kept: &mut Kept,
    closest: bool,
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
    let octant = octant(ray);
    let lanes = SlabLanes::<S::F32x8>::splat(&slabs.unwrap_or_default(), octant);
    walk::<S>(bvh, (&lanes, octant), (ray.t_min, ray.t_max), boxed, kept, closest, visitor);
}

/// The same of slabs, within `t_min..=far`: the first `boxed` leaves by their boxes, and all others.
#[inline(always)]
pub(crate) fn walk<S: Simd>(
    bvh: &Tree,
    (lanes, octant): (&SlabLanes<S::F32x8>, usize),
    (t_min, mut far): (f32, f32),
    boxed: usize,
    kept: &mut Kept,
    closest: bool,
    visitor: &mut impl Visit,
) {
    let (mut unboxed, mut next) = (boxed, if boxed > 0 { 0 } else { BOTTOM });
    let Kept { stack, predictor } = kept;
    let (mut top, mut stack) = (stack.bottom(0), stack.entries());
    loop {
        // The next leaf: one without a box, or the next that begins before the best hit.
        let leaf = if unboxed < bvh.leaves.len() {
            unboxed += 1;
            unboxed - 1
        } else {
            loop {
                if next == BOTTOM {
                    next = if closest {
                        stack.pop_at_once(&mut top, far)
                    } else {
                        stack.pop_last(&mut top)
                    };
                    if next == BOTTOM {
                        return;
                    }
                }
                if next & LEAF != 0 {
                    break (std::mem::replace(&mut next, BOTTOM) ^ LEAF) as usize;
                }

                // A node: of its boxes that the ray meets one is next.
                let node = &bvh.nodes[next as usize];
                let (met, near) = lanes.meet(node, t_min, far);
                let bits = met.bits();
                if bits == 0 {
                    next = BOTTOM;
                    continue;
                }
                let first = if closest {
                    stack.push_nearest_first::<S>(&mut top, node, octant, met, near)
                } else if bits.is_power_of_two() {
                    // Often it is one alone. Where the closest is looked for, that is too often a surprise.
                    node.child_or_none(bits.trailing_zeros() as u8)
                } else {
                    stack.push_children::<S>(&mut top, node, octant, met)
                };
                next = predictor.follow(next, first);
            }
        };
        match visitor.visit(leaf) {
            Some(nearer) => far = nearer,
            None => return,
        }
    }
}
