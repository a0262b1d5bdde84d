//! The traversal of a packet: one stack for all of its rays.

use intertri::internal::prefetch;
use intertri::simd::{Lanes, Mask, Simd};

use crate::tree::{EMPTY, LEAF, Tree};
use crate::walk::single::SlabLanes;

/// The rays of a packet.
pub(super) const RAYS: usize = 16;

/// Where each ray enters a box; NaN for rays that miss it, so that no comparison holds.
#[derive(Clone, Copy, Debug)]
#[repr(align(64))]
struct Nears([f32; RAYS]);

/// The nodes and leaves that any of the rays have still to visit.
#[derive(Debug, Default)]
pub(super) struct PacketStack {
    nears: Vec<Nears>,
    children: Vec<u32>,
}

/// What a packet does at leaves.
pub(super) trait VisitTogether<F: Lanes<Scalar = f32>> {
    /// The t beyond which each ray looks for no hit; NaN for those that look for none, so that no comparison
    /// holds.
    fn far(&self) -> F;
    /// Tests the triangles of a leaf with the rays that reach it.
    fn visit(&mut self, leaf: usize, reaching: F::Mask);
}

impl PacketStack {
    /// Visits the leaves that any ray of an octant reaches, roughly front to back. Returns the number of nodes
    /// and leaves visited, and the sum of the numbers of rays that visited each.
    #[inline(always)]
    pub(super) fn traverse<S: Simd>(
        &mut self,
        tree: &Tree,
        (lanes, octant): (&SlabLanes<S::F32x16>, usize),
        t_min: S::F32x16,
        visitor: &mut impl VisitTogether<S::F32x16>,
    ) -> [usize; 2] {
        if self.children.len() < tree.stack {
            self.nears.resize(tree.stack, Nears([0.0; RAYS]));
            self.children.resize(tree.stack, EMPTY);
        }
        let Self { nears, children } = self;
        let none = S::F32x16::splat(f32::NAN);
        let (mut top, mut work) = (0, [0; 2]);
        if tree.thin_root != EMPTY {
            // The second tree is visited last.
            t_min.store(&mut nears[top].0);
            children[top] = tree.thin_root;
            top += 1;
        }
        if !tree.leaves.is_empty() {
            t_min.store(&mut nears[top].0);
            children[top] = 0;
            top += 1;
        }
        while top > 0 {
            top -= 1;
            let (child, near) = (children[top], S::F32x16::load(&nears[top].0));
            let far = visitor.far();
            let reaching = near.le(far);
            if !reaching.any() {
                continue;
            }
            work = [work[0] + 1, work[1] + reaching.bits().count_ones() as usize];
            if child & LEAF != 0 {
                visitor.visit((child ^ LEAF) as usize, reaching);
                continue;
            }
            let before = top;
            // The boxes of a node, far to near.
            let node = &tree.nodes[child as usize];
            for slot in (0..8).rev().map(|slot| slot ^ octant) {
                let (met, near) = lanes.meet_sides(
                    #[inline(always)]
                    |axis, upper| S::F32x16::splat(node.sides(axis, upper)[slot]),
                    t_min,
                    far,
                );
                // Other rays may seem to meet anything, even empty slots: their numbers may be NaN or infinite.
                let met = met & reaching;
                // Written without a branch: whether any ray meets a box is hard to predict.
                S::F32x16::select(met, near, none).store(&mut nears[top].0);
                children[top] = node.children()[slot];
                top += usize::from(met.any());
            }
            for &child in &children[before..top] {
                prefetch_child(tree, child);
            }
        }
        work
    }
}

/// Prefetches a node or leaf.
#[inline(always)]
fn prefetch_child(tree: &Tree, child: u32) {
    if child & LEAF != 0 {
        prefetch(&tree.leaves[(child ^ LEAF) as usize..][..1]);
    } else {
        prefetch(&tree.nodes[child as usize..][..1]);
    }
}
