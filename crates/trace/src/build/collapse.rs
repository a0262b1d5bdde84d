//! Plans how to cut a two-way tree into eight-way nodes and blocks of eight triangles.
//!
//! This follows Ylitie, Karras, and Laine, *Efficient Incoherent Ray Traversal on GPUs Through
//! Compressed Wide BVHs* (2017), section 3. For each two-way node and each `i`, this module
//! computes the least cost of representing the node's triangles by at most `i` children of some
//! wide node:
//!
//! - One child is either a wide node, whose eight slots are divided between the two sides, or a
//!   block, which ends the two-way tree.
//! - Several children either divide `i` between the two sides, or use only `i - 1`.

/// The cost of visiting a node.
pub(crate) const NODE: f32 = 1.0;

/// The cost of visiting a block, whether full or not.
pub(crate) const LEAF: f32 = 1.0;

/// The least costs of representing a subtree by at most 1, 2, ..., 7 children. They never increase
/// with the number of children.
#[derive(Clone, Copy)]
pub(super) struct Costs([f32; 7]);

/// The choices behind the costs of a two-way node. For each number of children from 2 to 8, three
/// bits store how many of them the left side gets, or 0 to use one child fewer.
#[derive(Clone, Copy)]
pub(super) struct Plan(pub u32);

impl Costs {
    /// Returns the costs of a block, which are the same for any number of children.
    #[inline(always)]
    pub(super) fn of_block(area: f32) -> Self {
        Self([area * LEAF; 7])
    }

    /// Computes the costs and choices for a node from the costs of its two sides.
    #[inline(always)]
    pub(super) fn join(area: f32, left: &Self, right: &Self) -> (Self, Plan) {
        // Find the cheapest way to divide 2 to 8 children between the two sides.
        let mut shared = [f32::INFINITY; 9];
        let mut plan = 0;
        for (children, least) in shared.iter_mut().enumerate().skip(2) {
            let mut best = 0;
            for k in 1..children {
                // Give `k` children to the left side and the rest to the right.
                let cost = left.0[k - 1] + right.0[children - k - 1];
                if cost < *least {
                    (*least, best) = (cost, k as u32);
                }
            }
            plan |= best << (3 * (children - 2));
        }
        // One child: a wide node, whose eight slots are divided between the two sides.
        let one = shared[8] + area * NODE;
        // `costs[i]` allows up to i + 1 children. A single child may be cheaper than several.
        let mut costs = [one; 7];
        for i in 1..7 {
            costs[i] = shared[i + 1];
            // If fewer children cost no more, use their plan, which is encoded as 0.
            if costs[i - 1] <= costs[i] {
                costs[i] = costs[i - 1];
                plan &= !(7 << (3 * (i - 1)));
            }
        }
        (Self(costs), Plan(plan))
    }
}

impl Plan {
    /// Returns how many children the left side gets if there may be up to `children` (2 to 8), or 0
    /// to use one child fewer.
    pub(super) fn left(self, children: usize) -> usize {
        (self.0 >> (3 * (children - 2)) & 7) as usize
    }
}
