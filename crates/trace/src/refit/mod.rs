//! Refitting: the same tree around triangles that have moved.
//!
//! ```text
//!   leaves   new corners, live lanes and boxes                     in parallel
//!   nodes    boxes around those of their children, from the last node up
//!   the rest triangles that no box can contain, or that the build left out
//! ```
//!
//! A triangle keeps its lane in a leaf even while it cannot be hit: the lane is dead until it can be hit
//! again. A triangle without area keeps its corners there, for closest points.

mod error;
#[cfg(test)]
mod tests;

pub use error::RefitError;

use crate::build::Triangles;
use crate::tree::{Aabb, EMPTY, HitBounds, LEAF, LeafBounds, Node, Tree, lean_of};
use crate::util::lane_ops::lanes_of;
use crate::util::memory::{NoMemory, room};
use crate::util::threads;

/// How good a tree is after [`Bvh::refit`](crate::Bvh::refit).
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct Refit {
    /// The current surface-area cost: how many nodes and leaves a random line through the root's box is
    /// expected to visit. Leaves without a box always count.
    pub cost: f64,
    /// The cost when it was built.
    pub cost_as_built: f64,
}

impl Refit {
    /// A tree that costs this many times as much as when it was built may be worth rebuilding.
    pub const WORN: f64 = 1.5;

    /// The current cost divided by that of the build: 1 if no triangle has moved, larger the more the tree is
    /// worn.
    pub fn ratio(&self) -> f64 {
        self.cost / self.cost_as_built
    }

    /// Whether rebuilding may be worthwhile: the [`ratio`](Self::ratio) is above [`Refit::WORN`], and rays
    /// may take correspondingly longer. This is a hint: answers are right however worn the tree is, and for a
    /// crumpled mesh a new tree may cost as much.
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
        // Computed before the first refit, and compared with after each.
        self.cost_as_built = Some(cost_as_built);

        // Find the triangles that are not in the tree before the tree changes.
        let left_out = self.left_out()?;
        // The second tree is rebuilt, not refitted, because triangles enter and leave it.
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

    /// Fits the leaves of the tree to their triangles, and finds their boxes.
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

    /// Fits the boxes of all nodes to those of the leaves.
    fn fit_nodes(&mut self, leaves: &[LeafBounds]) -> Result<(), NoMemory> {
        // A node comes after its parent, so in reverse order all children are done before their parent.
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
        // Writing the boxes into the nodes is most of the work, and the nodes are independent now.
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

    /// The triangles that are no longer below the root, or never were, and can be hit; and those outside it
    /// without area.
    fn outside(
        &self,
        triangles: &(impl Triangles + ?Sized),
        bounds: &[LeafBounds],
        left_out: &[u32],
    ) -> Result<[Vec<u32>; 2], NoMemory> {
        // Triangles in leaves that have become needles: no box bounds the reference's hits with them.
        let mut outside = Vec::new();
        for (leaf, bounds) in self.leaves.iter().zip(bounds) {
            for lane in lanes_of(bounds.thin) {
                outside.try_reserve(1)?;
                outside.push(leaf.indices[lane]);
            }
        }
        // Triangles that were never in the tree may have become finite, or gained an area.
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
