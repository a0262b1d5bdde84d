//! One ray through the hierarchy, front to back.

use intertri::Ray;
use intertri::simd::{Lanes, Mask, Simd};

use intertri::internal::Resolver;

use super::slab::{SlabLanes, Slabs, octant};
use super::stack::{BOTTOM, TraversalScratch};
use crate::tree::{LEAF, Tree};

/// What a query does with the leaves that a ray reaches.
///
/// A trait and not a closure: its method must be inlined into the traversal, or it is compiled without the
/// level's instructions.
pub(crate) trait Visit {
    /// Tests the triangles of a leaf. Returns the new far end of the query, or `None` to stop.
    fn visit(&mut self, leaf: usize) -> Option<f32>;
}

/// The origin and the direction among the numbers of a ray.
const ORIGIN_AND_DIR: u32 = 0b0111_0111;

/// Visits the leaves whose triangles a ray may hit, roughly front to back. For a `closest` query the nearest box of a
/// node always comes first, so that fewer leaves are visited before the hit. Other queries must not bring the far end
/// nearer, because for them nothing on the stack is dropped.
#[inline(always)]
pub(super) fn traverse<S: Simd>(
    tree: &Tree,
    (ray, resolver): (&Ray, Resolver<'_>),
    kept: &mut TraversalScratch,
    closest: bool,
    visitor: &mut impl Visit,
) {
    // A ray that is not finite hits nothing, nor does one without an interval.
    // A ray is eight floats, so one comparison covers them all.
    let numbers = S::F32x8::load(bytemuck::cast_ref::<Ray, [f32; 8]>(ray));
    let finite = numbers.abs().le(S::F32x8::splat(f32::MAX)).bits();
    let can_hit = finite & ORIGIN_AND_DIR == ORIGIN_AND_DIR && ray.t_min < ray.t_max;
    if !can_hit {
        return;
    }

    let (octant, margin) = (octant(ray), tree.margin(resolver));
    let unboxed = tree.first_unboxed(resolver);
    let mut walk =
        Walk { tree, octant, t_min: ray.t_min, far: ray.t_max, shortens: true, unboxed, closest };
    let slabs = match Slabs::new::<S>(ray, &margin) {
        Some(slabs) => slabs,
        // A ray without a direction hits nothing.
        None if ray.dir == [0.0; 3] => return,
        None => {
            // A ray with extreme numbers is traversed in a scale of its own, in which no hit shortens it, or tested
            // with every triangle.
            let scaled = Slabs::scaled::<S>(ray, &margin);
            // Its t in that scale says nothing about the ray's own, so the interval is open.
            let unboxed = if scaled.is_some() { unboxed } else { 0 };
            walk = Walk { t_min: 0.0, far: f32::INFINITY, shortens: false, unboxed, ..walk };
            scaled.unwrap_or_default()
        }
    };
    walk.run::<S>(&SlabLanes::splat(&slabs, octant), kept, visitor);
}

/// A walk along slabs: what it visits, and how.
#[derive(Clone, Copy)]
pub(crate) struct Walk<'a> {
    pub(crate) tree: &'a Tree,
    pub(crate) octant: usize,
    /// The interval; whether its far end comes nearer with what visitors find.
    pub(crate) t_min: f32,
    pub(crate) far: f32,
    pub(crate) shortens: bool,
    /// The leaves from here on are visited whatever their boxes.
    pub(crate) unboxed: usize,
    pub(crate) closest: bool,
}

impl Walk<'_> {
    #[inline(always)]
    pub(crate) fn run<S: Simd>(
        self,
        lanes: &SlabLanes<S::F32x8>,
        kept: &mut TraversalScratch,
        visitor: &mut impl Visit,
    ) {
        let Self { tree, octant, t_min, mut far, shortens, mut unboxed, closest } = self;
        let thin_root = tree.thin_root_for(unboxed);
        let TraversalScratch { stack, predictor } = kept;
        let (mut top, mut stack) = (stack.bottom(0), stack.entries());
        // Where every leaf is visited anyway, there is nothing to traverse.
        let mut next = if unboxed > 0 { 0 } else { BOTTOM };
        if thin_root != BOTTOM {
            stack.push_root(&mut top, thin_root);
        }
        loop {
            // The next leaf: one without a box, or the next that begins before the best hit.
            let leaf = if unboxed < tree.leaves.len() {
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
                        // After the leaf, the next node comes from the stack.
                        break (std::mem::replace(&mut next, BOTTOM) ^ LEAF) as usize;
                    }

                    // A node: one of the boxes that the ray meets is next.
                    let node = &tree.nodes[next as usize];
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
                    // Equals `first`. But where the guess is right, the CPU can fetch that node before the box test is
                    // done.
                    next = predictor.follow(next, first);
                }
            };
            match visitor.visit(leaf) {
                Some(nearer) if shortens => far = nearer,
                Some(_) => {}
                None => return,
            }
        }
    }
}
