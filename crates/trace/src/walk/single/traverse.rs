//! Traces one ray through the hierarchy, front to back.

use intertri::Ray;
use intertri::simd::{Lanes, Mask, Simd};

use intertri::internal::Resolver;

use super::slab::{SlabLanes, Slabs, octant};
use super::stack::{BOTTOM, TraversalScratch};
use crate::tree::{EMPTY, LEAF, Node, Tree};

/// What a query does at each leaf that a ray reaches.
///
/// This is a trait rather than a closure because the method must be inlined into the traversal;
/// otherwise, it would be compiled without the SIMD level's instructions.
pub(crate) trait Visit {
    /// Tests the triangles of a leaf. Returns the new far end of the query, or `None` to stop.
    fn visit(&mut self, leaf: usize) -> Option<f32>;
}

/// A bit mask of the lanes that hold a ray's origin and direction when the ray is loaded as eight
/// floats.
const ORIGIN_AND_DIR: u32 = 0b0111_0111;

/// Visits the leaves whose triangles a ray may hit, roughly front to back. If `closest` is true,
/// the nearest box of each node is visited first, so that fewer leaves are visited before the hit
/// is found. Otherwise, the visitor must not move the far end nearer, because every entry of the
/// stack is visited.
#[inline(always)]
pub(super) fn traverse<S: Simd>(
    tree: &Tree,
    (ray, resolver): (&Ray, Resolver<'_>),
    kept: &mut TraversalScratch,
    closest: bool,
    visitor: &mut impl Visit,
) {
    // A ray with a non-finite origin or direction hits nothing, and neither does a ray with an
    // empty interval. A ray consists of eight floats, so a single vector comparison covers them
    // all.
    let numbers = S::F32x8::load(bytemuck::cast_ref::<Ray, [f32; 8]>(ray));
    let finite = numbers.abs().le(S::F32x8::splat(f32::MAX)).bits();
    let can_hit = finite & ORIGIN_AND_DIR == ORIGIN_AND_DIR && ray.t_min < ray.t_max;
    if !can_hit {
        return;
    }

    let (octant, margin) = (octant(ray), tree.margin(resolver));
    let unboxed = tree.first_unboxed(resolver);
    let interval = [ray.t_min, ray.t_max];
    let mut walk = Walk { shortens: true, closest, ..Walk::new(tree, octant, interval, unboxed) };
    let slabs = match Slabs::new::<S>(ray, &margin) {
        Some(slabs) => slabs,
        // A ray whose direction is zero hits nothing. Compare bits, because a CPU may be set to read
        // subnormal numbers as 0.
        None if ray.dir.map(f32::to_bits).iter().all(|x| x << 1 == 0) => return,
        None => {
            // A ray with extreme coordinates is scaled for traversal, and hits do not shorten it.
            // If scaling is impossible, every triangle is tested.
            let scaled = Slabs::scaled::<S>(ray, &margin);
            // The scaled ray's t is unrelated to the original t, so its interval is unbounded.
            let unboxed = if scaled.is_some() { unboxed } else { 0 };
            let walk_all = Walk::new(tree, octant, [0.0, f32::INFINITY], unboxed);
            walk = Walk { closest, ..walk_all };
            scaled.unwrap_or_default()
        }
    };
    walk.run::<S>(&SlabLanes::splat(&slabs, octant), kept, visitor);
}

/// The parameters of a traversal.
#[derive(Clone, Copy)]
pub(crate) struct Walk<'a> {
    pub(crate) nodes: &'a [Node],
    /// The number of leaves.
    pub(crate) leaves: usize,
    /// Leaves from this index on are visited regardless of their boxes.
    pub(crate) unboxed: usize,
    /// The root of the second tree, or [`EMPTY`] if there is none.
    pub(crate) thin_root: u32,
    pub(crate) octant: usize,
    /// The near end of the ray's interval.
    pub(crate) t_min: f32,
    /// The far end of the ray's interval.
    pub(crate) far: f32,
    /// Whether visitors may move the far end nearer.
    pub(crate) shortens: bool,
    /// Whether the nearest box of each node is visited first.
    pub(crate) closest: bool,
}

impl<'a> Walk<'a> {
    /// Creates a traversal that visits leaves from `unboxed` on regardless of their boxes. Visitors
    /// cannot shorten its interval.
    #[inline(always)]
    pub(crate) fn new(
        tree: &'a Tree,
        octant: usize,
        [t_min, far]: [f32; 2],
        unboxed: usize,
    ) -> Self {
        let (nodes, leaves, thin_root) =
            (&*tree.nodes, tree.leaves.len(), tree.thin_root_for(unboxed));
        let (shortens, closest) = (false, false);
        Self { nodes, leaves, unboxed, thin_root, octant, t_min, far, shortens, closest }
    }
}

impl Walk<'_> {
    #[inline(always)]
    pub(crate) fn run<S: Simd>(
        self,
        lanes: &SlabLanes<S::F32x8>,
        kept: &mut TraversalScratch,
        visitor: &mut impl Visit,
    ) {
        let Self { nodes, leaves, mut unboxed, thin_root, octant, .. } = self;
        let Self { t_min, mut far, shortens, closest, .. } = self;
        let TraversalScratch { stack, predictor } = kept;
        let (mut top, mut stack) = (stack.bottom(0), stack.entries());
        // If every leaf is visited anyway, there is nothing to traverse.
        let mut next = if unboxed > 0 { 0 } else { BOTTOM };
        if thin_root != EMPTY {
            stack.push_root(&mut top, thin_root);
        }
        loop {
            // Find the next leaf: either a leaf without a box or the next leaf that the traversal
            // reaches.
            let leaf = if unboxed < leaves {
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
                        // After this leaf, the traversal continues with the next entry of the
                        // stack.
                        break (std::mem::replace(&mut next, BOTTOM) ^ LEAF) as usize;
                    }

                    // At an inner node, continue with one of the children whose boxes the ray hits.
                    let node = &nodes[next as usize];
                    let (met, near) = lanes.meet(node, t_min, far);
                    let bits = met.bits();
                    if bits == 0 {
                        next = BOTTOM;
                        continue;
                    }
                    let first = if closest {
                        stack.push_nearest_first::<S>(&mut top, node, octant, met, near)
                    } else if bits.is_power_of_two() {
                        // Often, the ray hits only one box, so nothing is pushed. Closest-hit
                        // queries avoid this branch, because they would often mispredict it.
                        node.child_or_none(bits.trailing_zeros() as u8)
                    } else {
                        stack.push_children::<S>(&mut top, node, octant, met)
                    };
                    // `follow` always returns `first`, but if its guess is right, the CPU can fetch
                    // that node before the box tests are done.
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
