//! Refits the tree after its triangles have moved.
//!
//! ```text
//!   leaves   new corners, live lanes, and boxes, in parallel
//!   nodes    boxes around their children's boxes, from the last node up
//!   the rest triangles that no box can contain or that the build omitted
//! ```
//!
//! A triangle keeps its lane in a leaf even if it can no longer be hit: the lane is dead until the
//! triangle can be hit again. A triangle with zero area keeps its corners in its lane for
//! closest-point queries.

mod error;
#[cfg(test)]
mod tests;

pub use error::RefitError;

use crate::build::Triangles;
use crate::tree::{Aabb, EMPTY, HitBounds, LEAF, LeafBounds, Node, Tree, lean_of};
use crate::util::lane_ops::lanes_of;
use crate::util::memory::{NoMemory, room};
use crate::util::threads;

/// The quality of a tree after [`Bvh::refit`](crate::Bvh::refit).
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct Refit {
    /// The current surface-area cost: the expected number of nodes and leaves that a random line
    /// through the root's box visits. Leaves without a box are always counted.
    pub cost: f64,
    /// The cost of the tree as it was built.
    pub cost_as_built: f64,
}

impl Refit {
    /// The cost ratio above which a tree may be worth rebuilding.
    pub const WORN: f64 = 1.5;

    /// Returns the current cost divided by the cost as built. The ratio is 1 if no triangle has
    /// moved, and grows as the tree degrades.
    pub fn ratio(&self) -> f64 {
        self.cost / self.cost_as_built
    }

    /// Returns whether rebuilding may be worthwhile, that is, whether the [`ratio`](Self::ratio) is
    /// above [`Refit::WORN`]. Tracing may then take correspondingly longer. This is only a hint:
    /// results are correct however degraded the tree is, and for a crumpled mesh a new tree may
    /// cost just as much.
    pub fn is_worn(&self) -> bool {
        self.ratio() > Self::WORN
    }
}

impl Tree {
    /// Moves the triangles. If memory runs out, the tree is left empty.
    pub(crate) fn refit(
        &mut self,
        triangles: &(impl Triangles + ?Sized),
    ) -> Result<Refit, RefitError> {
        let (expected, found) = (self.triangles, triangles.count());
        if expected != found {
            return Err(RefitError::Count { expected, found });
        }
        self.refitted(triangles).map_err(|NoMemory| {
            self.clear();
            RefitError::OutOfMemory
        })
    }

    /// Removes all triangles.
    pub(crate) fn clear(&mut self) {
        (self.nodes, self.leaves) = (vec![Node::NO_CHILDREN], Vec::new());
        self.degenerate = Vec::new();
        (self.boxed, self.thin_root, self.reach, self.lean) = (0, EMPTY, 0.0, 0.0);
    }

    fn refitted(&mut self, triangles: &(impl Triangles + ?Sized)) -> Result<Refit, NoMemory> {
        let cost_as_built = match self.cost_as_built {
            Some(cost) => cost,
            None => self.cost()?,
        };
        // Before the first refit, compute the original cost for comparison with later costs.
        self.cost_as_built = Some(cost_as_built);

        // Before changing the tree, find the triangles that are not in the main tree.
        let left_out = self.left_out()?;
        // The second tree is rebuilt, not refitted, because triangles may enter or leave it.
        self.leaves.truncate(self.boxed);
        self.nodes.truncate(self.main_nodes().len());
        let bounds = self.fit_leaves(triangles)?;
        self.note_degenerate(&bounds)?;
        self.fit_nodes(&bounds)?;
        self.lean = lean_of(&bounds);
        let [outside, degenerate] = self.outside(triangles, &bounds, &left_out)?;
        self.add_unboxed(triangles, &outside, &degenerate)?;
        Ok(Refit { cost: self.cost()?, cost_as_built })
    }

    /// Refits the leaves to their triangles and returns their bounds.
    pub(crate) fn fit_leaves(
        &mut self,
        triangles: &(impl Triangles + ?Sized),
    ) -> Result<Vec<LeafBounds>, NoMemory> {
        threads::update(&mut self.leaves[..self.boxed], |leaf| {
            let around;
            (leaf.block, around) = triangles.moved(&leaf.indices);
            around
        })
    }

    /// Refits the boxes of all nodes to the boxes of the leaves.
    fn fit_nodes(&mut self, leaves: &[LeafBounds]) -> Result<(), NoMemory> {
        // Nodes come after their parents, so processing them in reverse order handles children
        // first.
        let mut around = room(self.nodes.len())?;
        around.resize(self.nodes.len(), Aabb::EMPTY);
        let of = |child: u32, around: &[Aabb]| match child & LEAF {
            0 => around[child as usize],
            _ => leaves[(child ^ LEAF) as usize].bounds,
        };
        for (i, node) in self.nodes.iter().enumerate().rev() {
            let mut all = Aabb::EMPTY;
            for &child in node.children().iter().filter(|&&child| child != EMPTY) {
                all.join(&of(child, &around));
            }
            around[i] = all;
        }
        // Most of the work is writing the boxes to the nodes. The nodes no longer depend on each
        // other, so write in parallel.
        threads::update(&mut self.nodes, |node| {
            for slot in 0..8 {
                let child = node.children()[slot];
                if child != EMPTY {
                    node.set(slot, &of(child, &around), child);
                }
            }
        })?;
        Ok(())
    }

    /// Lists the triangles that belong outside the main tree: first those that can be hit, then
    /// degenerate ones that the build omitted.
    fn outside(
        &self,
        triangles: &(impl Triangles + ?Sized),
        bounds: &[LeafBounds],
        left_out: &[u32],
    ) -> Result<[Vec<u32>; 2], NoMemory> {
        // Some triangles in leaves have become needles. No box bounds the hits that the reference
        // implementation finds on needles.
        let mut outside = Vec::new();
        for (leaf, bounds) in self.leaves.iter().zip(bounds) {
            for lane in lanes_of(bounds.thin) {
                outside.try_reserve(1)?;
                outside.push(leaf.indices[lane]);
            }
        }
        // Triangles that were never in the tree may have become finite or nondegenerate.
        let mut degenerate = Vec::new();
        for &index in left_out {
            let to = match triangles.hit_bounds(index as usize) {
                HitBounds::Nowhere => continue,
                HitBounds::Degenerate(_) => &mut degenerate,
                HitBounds::Box { .. } | HitBounds::Thin(_) => &mut outside,
            };
            to.try_reserve(1)?;
            to.push(index);
        }
        outside.sort_unstable();
        Ok([outside, degenerate])
    }
}
