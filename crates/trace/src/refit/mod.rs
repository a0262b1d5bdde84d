//! Refitting: the same tree around triangles that have moved.
//!
//! ```text
//!   leaves   corners anew, who can be hit, the box around them     side by side
//!   nodes    boxes around their children's, from the last node up
//!   the rest triangles that no box can hold, or that the build had left out
//! ```
//!
//! A triangle keeps its place in a leaf, also while it can not be hit: its lane is dead until it can again. One without an
//! area keeps its corners there, for closest points.

mod error;
#[cfg(test)]
mod tests;

pub use error::RefitError;

use crate::across::lanes_of;
use crate::build::Triangles;
use crate::memory::{NoMemory, room};
use crate::threads;
use crate::tree::{Aabb, EMPTY, HitBounds, LEAF, Leaf, LeafBounds, NONE, Node, Tree};

/// How good a tree is after [`Bvh::refit`](crate::Bvh::refit).
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct Refit {
    /// The surface-area cost now: how many nodes and leaves a random line through the box around all is expected
    /// to visit. Leaves without a box count in full.
    pub cost: f64,
    /// The same as built.
    pub cost_as_built: f64,
}

impl Refit {
    /// A tree that costs so many times what it did may be worth a build.
    pub const WORN: f64 = 1.5;

    /// The cost now over that of the build: 1 for triangles that have not moved, more the more a tree has worn.
    pub fn ratio(&self) -> f64 {
        self.cost / self.cost_as_built
    }

    /// Whether it is time to build anew: the [`ratio`](Self::ratio) is above [`Refit::WORN`], and rays may take
    /// longer by as much. That is a hint: answers are right however worn the tree is, and a mesh that is
    /// crumpled may cost as much through a new one.
    pub fn is_worn(&self) -> bool {
        self.ratio() > Self::WORN
    }
}

impl Tree {
    /// Moves the triangles. Where there is too little memory, it holds none any more.
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

    /// Holds no triangle any more.
    pub(crate) fn clear(&mut self) {
        (self.nodes, self.leaves) = (vec![Node::NO_CHILDREN], Vec::new());
        self.degenerate = Vec::new();
        (self.boxed, self.reach) = (0, 0.0);
    }

    fn refitted(&mut self, triangles: &(impl Triangles + ?Sized)) -> Result<Refit, NoMemory> {
        let cost_as_built = match self.cost_as_built {
            Some(cost) => cost,
            None => self.cost()?,
        };
        self.cost_as_built = Some(cost_as_built);

        // Who has no place in the tree is known before it changes.
        let left_out = self.left_out()?;
        self.leaves.truncate(self.boxed);
        let bounds = self.fit_leaves(triangles)?;
        self.note_degenerate(&bounds)?;
        self.fit_nodes(&bounds)?;
        self.add_unboxed(triangles, &bounds, &left_out)?;
        self.reach = self.find_reach();
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
        // A node comes after its parent.
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

    /// Adds the leaves of triangles that are tested with every ray: of which no box is known, or which have no
    /// place in the tree.
    fn add_unboxed(
        &mut self,
        triangles: &(impl Triangles + ?Sized),
        bounds: &[LeafBounds],
        left_out: &[u32],
    ) -> Result<(), NoMemory> {
        let mut unboxed = Vec::new();
        for (leaf, bounds) in self.leaves.iter().zip(bounds) {
            for lane in lanes_of(bounds.unbounded) {
                unboxed.try_reserve(1)?;
                unboxed.push(leaf.indices[lane]);
            }
        }
        let mut degenerate = Vec::new();
        for &index in left_out {
            let to = match triangles.hit_bounds(index as usize) {
                HitBounds::Nowhere => continue,
                HitBounds::Degenerate(_) => &mut degenerate,
                HitBounds::Box(_) | HitBounds::Unbounded => &mut unboxed,
            };
            to.try_reserve(1)?;
            to.push(index);
        }
        unboxed.sort_unstable();

        let extra = unboxed.len().div_ceil(8) + degenerate.len().div_ceil(8);
        self.leaves.try_reserve(extra)?;
        self.leaves.extend(in_eights(&unboxed).map(|indices| {
            let block = triangles.block(&indices);
            Leaf { block, indices }
        }));
        if degenerate.is_empty() {
            return Ok(());
        }
        self.degenerate.try_reserve(self.leaves.len() + extra - self.degenerate.len())?;
        self.degenerate.resize(self.leaves.len(), 0);
        for indices in in_eights(&degenerate) {
            let (block, bounds) = triangles.moved(&indices);
            self.leaves.push(Leaf { block, indices });
            self.degenerate.push(bounds.degenerate as u8);
        }
        Ok(())
    }
}

/// Indices of triangles, eight by eight.
fn in_eights(all: &[u32]) -> impl Iterator<Item = [u32; 8]> + '_ {
    all.chunks(8).map(|some| {
        let mut indices = [NONE; 8];
        indices[..some.len()].copy_from_slice(some);
        indices
    })
}
