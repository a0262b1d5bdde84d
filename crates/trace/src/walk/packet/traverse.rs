//! Traverses a tree with a packet, using one stack for all its rays.

use intertri::internal::prefetch;
use intertri::simd::{Lanes, Mask, Simd};

use crate::tree::{EMPTY, LEAF, Node, Tree};
use crate::util::stop;
use crate::walk::single::SlabLanes;

/// The number of nodes and leaves that a packet visits between two checks for cancellation.
const CHECK: usize = 256;

/// The number of rays in a packet.
pub(crate) const RAYS: usize = 16;

/// The t at which each ray enters a box; NaN for rays that miss it, so that all comparisons are
/// false.
#[derive(Clone, Copy, Debug)]
#[repr(align(64))]
struct Nears([f32; RAYS]);

/// The nodes and leaves that at least one ray still has to visit.
#[derive(Debug, Default)]
pub(crate) struct PacketStack {
    nears: Vec<Nears>,
    children: Vec<u32>,
}

/// The boxes that packets traverse.
#[derive(Clone, Copy)]
pub(crate) struct Boxes<'a> {
    pub(crate) nodes: &'a [Node],
    /// The roots, or [`EMPTY`] where there is none. The last root is visited first.
    pub(crate) roots: [u32; 2],
    /// The stack size required by the depth of the tree.
    pub(crate) stack: usize,
}

impl<'a> Boxes<'a> {
    /// Returns the boxes of a tree. The root of the second tree, which holds thin triangles, is
    /// visited last.
    #[inline(always)]
    pub(crate) fn of(tree: &'a Tree) -> Self {
        let root = if tree.leaves.is_empty() { EMPTY } else { 0 };
        Self { nodes: &tree.nodes, roots: [tree.thin_root, root], stack: tree.stack }
    }
}

/// Defines what a packet does at leaves.
pub(crate) trait VisitTogether<F: Lanes<Scalar = f32>> {
    /// Returns, for each ray, the t beyond which hits no longer count; NaN for finished rays, so
    /// that all comparisons are false.
    fn far(&self) -> F;
    /// Tests a leaf against the rays that reach it.
    fn visit(&mut self, leaf: usize, reaching: F::Mask);
    /// Prefetches a leaf.
    fn prefetch(&self, leaf: usize);
}

impl PacketStack {
    /// Visits the leaves that any ray in an octant reaches, roughly front to back. Returns the
    /// number of nodes and leaves visited, and the sum over these of the number of rays visiting
    /// each.
    #[inline(always)]
    pub(crate) fn traverse<S: Simd>(
        &mut self,
        boxes: Boxes<'_>,
        (lanes, octant): (&SlabLanes<S::F32x16>, usize),
        t_min: S::F32x16,
        visitor: &mut impl VisitTogether<S::F32x16>,
    ) -> [usize; 2] {
        if self.children.len() < boxes.stack {
            self.nears.resize(boxes.stack, Nears([0.0; RAYS]));
            self.children.resize(boxes.stack, EMPTY);
        }
        let Self { nears, children } = self;
        let none = S::F32x16::splat(f32::NAN);
        let (mut top, mut work) = (0, [0; 2]);
        for root in boxes.roots {
            if root != EMPTY {
                t_min.store(&mut nears[top].0);
                children[top] = root;
                top += 1;
            }
        }
        while top > 0 {
            top -= 1;
            let (child, near) = (children[top], S::F32x16::load(&nears[top].0));
            let far = visitor.far();
            let reaching = near.le(far);
            if !reaching.any() {
                continue;
            }
            // A packet may visit millions of triangles, for example at the centre of a fan.
            if work[0] % CHECK == CHECK - 1 {
                stop::check();
            }
            work = [work[0] + 1, work[1] + reaching.bits().count_ones() as usize];
            if child & LEAF != 0 {
                visitor.visit((child ^ LEAF) as usize, reaching);
                continue;
            }
            let before = top;
            // Push the boxes of a node far to near.
            let node = &boxes.nodes[child as usize];
            for slot in (0..8).rev().map(|slot| slot ^ octant) {
                let (met, near) = lanes.meet_sides(
                    #[inline(always)]
                    |axis, upper| S::F32x16::splat(node.sides(axis, upper)[slot]),
                    t_min,
                    far,
                );
                // Rays that do not reach the node may appear to hit any box, even that of an empty
                // slot, because their values may be NaN or infinite.
                let met = met & reaching;
                // Avoid a branch, because it is hard to predict whether any ray hits a box.
                S::F32x16::select(met, near, none).store(&mut nears[top].0);
                children[top] = node.children()[slot];
                top += usize::from(met.any());
            }
            for &child in &children[before..top] {
                if child & LEAF != 0 {
                    visitor.prefetch((child ^ LEAF) as usize);
                } else {
                    prefetch(&boxes.nodes[child as usize..][..1]);
                }
            }
        }
        work
    }
}
