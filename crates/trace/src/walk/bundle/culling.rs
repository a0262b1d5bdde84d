//! Culls nodes against the frustum of a bundle's rays, front to back.

use intertri::internal::prefetch;
use intertri::simd::{Lanes, Simd};

use super::end_plane::EndPlane;
use super::frustum::Frustum;
use crate::tree::{LEAF, Tree, far_to_near};
use crate::util::stop;

/// The nodes and leaves still to be visited, each with its depth. The next one to visit is on top.
pub(super) type Pending = Vec<(u32, f32)>;

/// The bounds of the current rays.
pub(super) struct Culling<'a> {
    pub(super) frustum: Frustum,
    /// A plane in front of which all rays end, if one is known.
    pub(super) end_plane: Option<&'a EndPlane>,
    /// Whether hits shorten the rest of the traversal, as in closest-hit queries.
    pub(super) closest: bool,
}

impl Culling<'_> {
    /// Fills `leaves` with the next leaves that a ray may reach before the depth `far`. Returns
    /// their number, which is smaller than the slice only if no more leaves remain.
    #[inline(always)]
    pub(super) fn next_leaves<S: Simd>(
        &self,
        tree: &Tree,
        stack: &mut Pending,
        far: f32,
        leaves: &mut [u32],
    ) -> usize {
        stop::heed();
        let mut count = 0;
        for to in leaves {
            let Some(leaf) = self.next_leaf::<S>(tree, stack, far) else { break };
            *to = leaf;
            count += 1;
        }
        count
    }

    #[inline(always)]
    fn next_leaf<S: Simd>(&self, tree: &Tree, stack: &mut Pending, far: f32) -> Option<u32> {
        loop {
            let (child, near) = stack.pop()?;
            // When this entry was pushed, rays still reached farther.
            if near > far {
                continue;
            }
            if child & LEAF != 0 {
                return Some(child ^ LEAF);
            }
            let node = &tree.nodes[child as usize];
            let (met, near) = self.frustum.meet::<S::F32x8>(node, far, self.end_plane);
            let mut depth = [0.0; 8];
            near.store(&mut depth);
            // The entry pushed last is visited first.
            let mut order = far_to_near(met, self.frustum.octant).to_le_bytes();
            if self.closest && met.count_ones() > 1 {
                let mut middles = [0.0; 8];
                // Store twice the depth of each box's centre. For a wide frustum, sorting by these
                // depths is better than using the octant's order.
                (near + self.frustum.far::<S::F32x8>(node)).store(&mut middles);
                by_middle(&mut order[..met.count_ones() as usize], &middles);
            }
            for &slot in &order[..met.count_ones() as usize] {
                let slot = usize::from(slot % 8);
                let child = node.children()[slot];
                stack.push((child, depth[slot]));
                match child & LEAF {
                    0 => prefetch(&tree.nodes[child as usize..][..1]),
                    _ => prefetch(&tree.leaves[(child ^ LEAF) as usize..][..1]),
                }
            }
        }
    }
}

/// Sorts slots by their centres, farthest first. A long box, such as that of a wall, begins near,
/// so neither its near depth nor its slot is a good guide. Since most slots are already in order,
/// this is an insertion sort.
#[inline(always)]
fn by_middle(slots: &mut [u8], middles: &[f32; 8]) {
    let middle = |slot: u8| middles[usize::from(slot % 8)];
    for i in 1..slots.len() {
        let (slot, mut to) = (slots[i], i);
        // There are at most eight slots, and they are almost sorted.
        while to > 0 && middle(slots[to - 1]) < middle(slot) {
            slots[to] = slots[to - 1];
            to -= 1;
        }
        slots[to] = slot;
    }
}

#[cfg(test)]
mod tests {
    use super::by_middle;

    #[test]
    fn the_farthest_comes_first() {
        let middles = [3.0, -1.0, 0.5, f32::NEG_INFINITY, 1e30, -2.0, 7.0, f32::INFINITY];
        let sorted = |mut slots: Vec<u8>| {
            by_middle(&mut slots, &middles);
            slots
        };
        assert_eq!(sorted((0..8).collect()), [7, 4, 6, 0, 2, 1, 5, 3]);
        assert_eq!(sorted(vec![3, 1, 6, 5]), [6, 1, 5, 3]);
        assert_eq!(sorted(vec![]), []);
    }
}
