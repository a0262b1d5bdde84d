//! Refitting: the same tree around triangles that have moved.
//!
//! ```text
//!   leaves   corners anew, who can be hit, the box around them     side by side
//!   nodes    boxes around their children's, from the last node up
//!   the rest triangles that no box can hold, or that the build had left out
//! ```
//!
//! A triangle keeps its place in a leaf, also while it can not be hit: its lane is dead until it can again.

mod error;
#[cfg(test)]
mod tests;

pub use error::RefitError;

use intertri::simd::{Level, Simd, WithSimd};
use intertri::{Triangle, TriangleBlock};

use crate::across::lanes_of;
use crate::bvh::Bvh;
use crate::memory::{NoMemory, room};
use crate::threads;
use crate::tree::{
    Aabb, EMPTY, HitBounds, LEAF, LaneBounds, Leaf, LeafBounds, NONE, Node, Tree, hit_bounds,
};

/// How good a tree is after [`Bvh::refit`].
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

impl Bvh {
    /// Moves the triangles: their new corners, all of them in the order in which they were given. The tree stays
    /// as it is, in place; its boxes are fitted to the corners, on all threads.
    ///
    /// Answers are those of a hierarchy built anew, bit for bit. It takes a small part of the time of a build, but
    /// the more the triangles move against each other, the longer rays take; [`Refit`] tells how worn the tree
    /// is. Triangles may lose their area or stop being finite, and come back.
    ///
    /// # Errors
    /// If there are more triangles or fewer: then nothing has changed. If there is too little memory: then it
    /// holds no triangle any more.
    ///
    /// ```
    /// use intertri_trace::Bvh;
    /// use intertri_trace::intertri::{Exact, Ray, Triangle};
    /// let floor = |y| Triangle::new([-1.0, y, -1.0], [3.0, y, -1.0], [-1.0, y, 3.0]);
    /// let ray = Ray::new([0.0, 9.0, 0.0], [0.0, -1.0, 0.0]);
    /// let mut bvh = Bvh::new(&[floor(0.0), floor(1.0)])?;
    /// let refit = bvh.refit(&[floor(5.0), floor(3.0)])?;
    /// let hit = bvh.closest(&Exact::default(), &ray);
    /// assert_eq!(hit.map(|hit| (hit.triangle, hit.t)), Some((0, 4.0)));
    /// assert!(refit.ratio() > 0.0 && !refit.is_worn());
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn refit(&mut self, triangles: &[Triangle]) -> Result<Refit, RefitError> {
        self.tree.refit(triangles)
    }
}

impl Tree {
    /// See [`Bvh::refit`].
    fn refit(&mut self, triangles: &[Triangle]) -> Result<Refit, RefitError> {
        let (expected, found) = (self.triangles, triangles.len());
        if expected != found {
            return Err(RefitError::Count { expected, found });
        }
        self.refitted(triangles).map_err(|NoMemory| {
            (self.nodes, self.leaves) = (vec![Node::NO_CHILDREN], Vec::new());
            (self.boxed, self.reach) = (0, 0.0);
            RefitError::OutOfMemory
        })
    }

    fn refitted(&mut self, triangles: &[Triangle]) -> Result<Refit, NoMemory> {
        let cost_as_built = match self.cost_as_built {
            Some(cost) => cost,
            None => self.cost()?,
        };
        self.cost_as_built = Some(cost_as_built);

        // Who has no place in the tree is known before it changes.
        let left_out = self.left_out()?;
        self.leaves.truncate(self.boxed);
        let level = Level::best();
        let fit = |leaf: &mut Leaf| {
            let around;
            (leaf.block, around) = level.run(Moved { triangles, indices: &leaf.indices });
            around
        };
        let bounds = threads::update(&mut self.leaves, fit)?;
        self.fit_nodes(&bounds)?;
        self.add_unboxed(triangles, &bounds, &left_out)?;
        self.reach = self.find_reach();
        Ok(Refit { cost: self.cost()?, cost_as_built })
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
        triangles: &[Triangle],
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
        unboxed.try_reserve(left_out.len())?;
        let can_be_hit =
            |&index: &u32| hit_bounds(&triangles[index as usize]) != HitBounds::Nowhere;
        unboxed.extend(left_out.iter().copied().filter(can_be_hit));
        unboxed.sort_unstable();

        self.leaves.try_reserve(unboxed.len().div_ceil(8))?;
        self.leaves.extend(unboxed.chunks(8).map(|some| {
            let mut indices = [NONE; 8];
            indices[..some.len()].copy_from_slice(some);
            let corners: Vec<Triangle> = some.iter().map(|&i| triangles[i as usize]).collect();
            Leaf { block: TriangleBlock::new(&corners), indices }
        }));
        Ok(())
    }
}

/// The triangles of a leaf where they are now, and the box around them.
struct Moved<'a> {
    triangles: &'a [Triangle],
    indices: &'a [u32; 8],
}

impl WithSimd for Moved<'_> {
    type Output = (TriangleBlock<8>, LeafBounds);

    #[inline(always)]
    fn run<S: Simd>(self) -> Self::Output {
        let (mut corners, mut lanes) = ([[[0.0; 8]; 3]; 3], 0);
        for (lane, &index) in self.indices.iter().enumerate() {
            if index == NONE {
                break;
            }
            lanes |= 1 << lane;
            let triangle = &self.triangles[index as usize];
            for (rows, corner) in corners.iter_mut().zip(&triangle.0) {
                for (row, &x) in rows.iter_mut().zip(corner) {
                    row[lane] = x;
                }
            }
        }
        let bounds = LaneBounds { corners: &corners, lanes }.run::<S>();

        // Dead lanes repeat one that is not.
        let dead = 0xff & !bounds.boxed;
        if dead != 0 {
            let live = bounds.boxed.trailing_zeros() as usize;
            for row in corners.as_flattened_mut() {
                let x = row.get(live).copied().unwrap_or(0.0);
                lanes_of(dead).for_each(|lane| row[lane] = x);
            }
        }
        (TriangleBlock::of_lanes_in::<S>(corners, bounds.boxed), bounds)
    }
}
