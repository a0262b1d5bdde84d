//! Traversal for closest points: visits the nearest boxes first and skips boxes that are certainly
//! farther away than a triangle already found.

use intertri::LeafSlot;
use intertri::internal::exact::squares;
use intertri::simd::{Lanes, Mask, Simd, Vec3};

use super::boxes;
use super::found::Candidate;
use super::mesh::{Mesh, QueryPoint};
use crate::tree::LEAF;
use crate::util::lane_ops::lanes_of;
use crate::walk::single::{BOTTOM, TraversalScratch};

/// A search for the triangle that is closest to a point.
pub(super) struct Search<'a, M> {
    pub(super) mesh: M,
    pub(super) at: QueryPoint,
    /// The largest squared distance that a candidate may have, in the tree's units.
    pub(super) most: f64,
    /// The triangles that may be the closest.
    pub(super) candidates: &'a mut Vec<Candidate>,
}

impl<M: Mesh> Search<'_, M> {
    /// Traverses the tree and collects candidates, starting with a leaf that is likely to be near,
    /// if one is known.
    #[inline(always)]
    pub(super) fn run<S: Simd>(&mut self, likely: Option<u32>, kept: &mut TraversalScratch) {
        let mesh = self.mesh;
        let (bvh, within) = (mesh.tree(), self.at.within.map(Vec3::<S::F32x8>::splat));
        // Starting with a nearby leaf makes `most` small, so traversal then skips nearly everything
        // else.
        self.candidates.clear();
        if let Some(leaf) = likely {
            self.leaf::<S>(leaf as usize);
        }
        // Few leaves are outside the main tree, so test them all.
        for leaf in bvh.boxed..bvh.leaves.len() {
            self.leaf::<S>(leaf);
        }

        let mut far = boxes::far_for(self.most);
        let (mut top, mut stack) = (kept.stack.bottom(0), kept.stack.entries());
        let mut next = if bvh.boxed > 0 { 0 } else { BOTTOM };
        loop {
            if next == BOTTOM {
                next = stack.pop_at_once(&mut top, far);
                if next == BOTTOM {
                    break;
                }
            }
            if next & LEAF != 0 {
                let leaf = (std::mem::replace(&mut next, BOTTOM) ^ LEAF) as usize;
                // The likely leaf has already been searched.
                if likely != Some(leaf as u32) && self.leaf::<S>(leaf) {
                    far = boxes::far_for(self.most);
                }
                continue;
            }
            let node = &bvh.nodes[next as usize];
            let (met, squares) = boxes::squares(node, within, far);
            next = if met.any() {
                // Push the other children in the order of octant 0, since there is no ray to
                // suggest a better order.
                stack.push_nearest_first::<S>(&mut top, node, 0, met, squares)
            } else {
                BOTTOM
            };
        }
        // `most` may have shrunk since earlier candidates were added.
        let most = self.most;
        self.candidates.retain(|candidate| candidate.least <= most);
    }

    /// Adds the triangles of a leaf that may be the closest. Returns whether any were added.
    #[inline(always)]
    fn leaf<S: Simd>(&mut self, leaf: usize) -> bool {
        let (mesh, at) = (self.mesh, self.at);
        let within = at.in_leaves.map(Vec3::<S::F32x8>::splat);
        let far = boxes::far_for(self.most);
        // The f32 bounding boxes of the eight triangles rule out most of them before any f64
        // arithmetic.
        let near = boxes::may_be_near(mesh.near_corners(leaf), within, far);
        let near = near.bits() & mesh.tree().present(leaf);
        if near == 0 {
            return false;
        }
        let found = squares(mesh.corners::<S>(leaf, near), Vec3::splat(at.point));
        let near = found.least.le(Lanes::splat(self.most)).bits() & near;
        if near == 0 {
            return false;
        }
        let (mut least, mut most) = ([0.0; 8], [0.0; 8]);
        found.least.store(&mut least);
        found.most.store(&mut most);
        // First lower `most` using all lanes, then add only the lanes that are still close enough.
        for lane in lanes_of(near) {
            self.most = if most[lane] < self.most { most[lane] } else { self.most };
        }
        for lane in lanes_of(near) {
            if least[lane] <= self.most {
                let slot = LeafSlot((8 * leaf + lane) as u32);
                self.candidates.push(Candidate { slot, least: least[lane] });
            }
        }
        true
    }
}
