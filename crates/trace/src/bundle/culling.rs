//! Nodes culled by the frustum of a bundle's rays, front to back.

use intertri::internal::prefetch;
use intertri::simd::{Lanes, Simd};

use super::end_plane::EndPlane;
use super::frustum::Frustum;
use crate::tree::{LEAF, Tree, far_to_near};

/// Nodes and leaves that are still to be visited, the nearest on top, each with its depth.
pub(super) type Pending = Vec<(u32, f32)>;

/// What bounds the rays that are asked now.
pub(super) struct Culling<'a> {
    pub(super) frustum: Frustum,
    /// Where it is known before which plane the rays end.
    pub(super) end_plane: Option<&'a EndPlane>,
}

impl Culling<'_> {
    /// The next leaves that some ray may meet before the depth `far`; as many as there is room for.
    #[inline(always)]
    pub(super) fn next_leaves<S: Simd>(
        &self,
        bvh: &Tree,
        stack: &mut Pending,
        far: f32,
        leaves: &mut [u32],
    ) -> usize {
        let mut count = 0;
        for to in leaves {
            let Some(leaf) = self.next_leaf::<S>(bvh, stack, far) else { break };
            *to = leaf;
            count += 1;
        }
        count
    }

    #[inline(always)]
    fn next_leaf<S: Simd>(&self, bvh: &Tree, stack: &mut Pending, far: f32) -> Option<u32> {
        loop {
            let (child, near) = stack.pop()?;
            if near > far {
                continue;
            }
            if child & LEAF != 0 {
                return Some(child ^ LEAF);
            }
            let node = &bvh.nodes[child as usize];
            let (met, near) = self.frustum.meet::<S::F32x8>(node, far, self.end_plane);
            let mut depth = [0.0; 8];
            near.store(&mut depth);
            let order = far_to_near(met, self.frustum.octant).to_le_bytes();
            for &slot in &order[..met.count_ones() as usize] {
                let slot = usize::from(slot % 8);
                let child = node.children()[slot];
                stack.push((child, depth[slot]));
                match child & LEAF {
                    0 => prefetch(&bvh.nodes[child as usize..][..1]),
                    _ => prefetch(&bvh.leaves[(child ^ LEAF) as usize..][..1]),
                }
            }
        }
    }
}
