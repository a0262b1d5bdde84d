//! The hierarchy used for traversal: nodes and leaves in f32.

use bytemuck::Zeroable;
use intertri::internal::Resolver;
use intertri::{LeafSlot, Triangle, TriangleBlock, TriangleId};

use super::geometries::Geometries;
use super::leaf_bounds::LeafBounds;
use super::node::{EMPTY, LEAF, NONE, Node};
use super::{Aabb, Margin};
use crate::util::memory::{NoMemory, copied, room};

/// A leaf: up to eight triangles in six cache lines.
#[derive(Clone, Copy, Debug, Zeroable)]
#[repr(C, align(64))]
pub(crate) struct Leaf {
    pub(crate) block: TriangleBlock<8>,
    /// The triangles' original indices.
    pub(crate) indices: [u32; 8],
}

const _: () = assert!(size_of::<Leaf>() == 384);

/// A tree of nodes and leaves over triangles, or over f32 copies of f64 triangles.
#[derive(Clone, Debug)]
pub struct Tree {
    /// The nodes, with the root first. A child that is a leaf is stored as its index in `leaves`.
    /// The nodes over the leaves from `boxed` on come last.
    pub(crate) nodes: Vec<Node>,
    /// The triangles in groups of eight.
    pub(crate) leaves: Vec<Leaf>,
    /// For each leaf, a mask of the triangles with zero area. Rays ignore these triangles, but
    /// closest-point queries consider them. The list is empty if no triangle is degenerate.
    pub(crate) degenerate: Vec<u8>,
    /// The number of leaves in the main tree, which come first. The other leaves contain needles,
    /// on which the reference implementation may report hits arbitrarily far outside them, and
    /// triangles that were not finite when the tree was built.
    pub(crate) boxed: usize,
    /// The root of a second tree over the other leaves, or [`EMPTY`] if there are no other leaves.
    pub(crate) thin_root: u32,
    /// The largest coordinate magnitude of any triangle.
    pub(crate) reach: f32,
    /// The maximum distance outside a triangle's box at which the reference implementation may
    /// report a hit, not counting a part that is proportional to the ray's origin.
    pub(crate) lean: f32,
    /// A stack size that is large enough for every traversal.
    pub(crate) stack: usize,
    pub(crate) triangles: usize,
    /// The geometries of the triangles.
    pub(crate) geometries: Geometries,
    /// The cost of the tree as it was built; known only after a refit.
    pub(crate) cost_as_built: Option<f64>,
}

impl Tree {
    /// Returns a copy, or an error if memory runs out.
    pub(crate) fn try_clone(&self) -> Result<Self, NoMemory> {
        Ok(Self {
            nodes: copied(&self.nodes)?,
            leaves: copied(&self.leaves)?,
            degenerate: copied(&self.degenerate)?,
            geometries: self.geometries.try_clone()?,
            ..*self
        })
    }

    /// Returns the triangles that are not in the main tree, in ascending order. These triangles
    /// were needles or not finite when the tree was built.
    pub(crate) fn left_out(&self) -> Result<Vec<u32>, NoMemory> {
        let in_tree = || {
            let indices = self.leaves[..self.boxed].iter().flat_map(|leaf| leaf.indices);
            indices.filter(|&index| index != NONE)
        };
        // In nearly all hierarchies, every triangle is in the main tree and no table is needed.
        if in_tree().count() == self.triangles {
            return Ok(Vec::new());
        }
        let mut is_in = room(self.triangles)?;
        is_in.resize(self.triangles, false);
        in_tree().for_each(|index| is_in[index as usize] = true);
        let mut left_out = room(is_in.iter().filter(|&&is_in| !is_in).count())?;
        left_out.extend((0..self.triangles as u32).filter(|&index| !is_in[index as usize]));
        Ok(left_out)
    }

    /// Returns a mask of the lanes of a leaf that hold a finite triangle rather than a filler.
    #[inline(always)]
    pub(crate) fn present(&self, leaf: usize) -> u32 {
        let degenerate = self.degenerate.get(leaf).map_or(0, |&lanes| u32::from(lanes));
        self.leaves[leaf].block.live() | degenerate
    }

    /// Records which lanes of each leaf hold degenerate triangles.
    pub(crate) fn note_degenerate(&mut self, bounds: &[LeafBounds]) -> Result<(), NoMemory> {
        self.degenerate = Vec::new();
        if bounds.iter().any(|leaf| leaf.degenerate != 0) {
            self.degenerate = room(bounds.len())?;
            self.degenerate.extend(bounds.iter().map(|leaf| leaf.degenerate as u8));
        }
        Ok(())
    }

    /// Returns the margin by which traversal must widen boxes for a resolver.
    #[inline(always)]
    pub(crate) fn margin(&self, resolver: Resolver<'_>) -> Margin {
        Margin::new(
            self.reach,
            if resolver.hits_lie_on_triangles() { None } else { Some(self.lean) },
        )
    }

    /// Returns the index of the first leaf that is tested against every ray. If all hits lie on
    /// their triangles, no leaf is tested against every ray, and traversal starts at both roots.
    #[inline(always)]
    pub(crate) fn first_unboxed(&self, resolver: Resolver<'_>) -> usize {
        if resolver.hits_lie_on_triangles() { self.leaves.len() } else { self.boxed }
    }

    /// Returns the second root, or [`EMPTY`] if traversal has already tested the leaves from
    /// `unboxed` on without boxes.
    #[inline(always)]
    pub(crate) fn thin_root_for(&self, unboxed: usize) -> u32 {
        if unboxed == self.leaves.len() { self.thin_root } else { EMPTY }
    }

    /// Builds the second tree over the leaves from `boxed` on, which have the given boxes. Each
    /// node groups eight neighbouring leaves, each node of the next level groups eight of these
    /// nodes, and so on.
    pub(crate) fn add_thin_nodes(&mut self, boxes: &[Aabb]) -> Result<(), NoMemory> {
        // Compute the number of nodes on each level, from the bottom up.
        let mut levels = Vec::new();
        let mut width = boxes.len();
        // Continue up to a single root. Even a single leaf gets a node above it.
        while width > usize::from(!levels.is_empty()) {
            width = width.div_ceil(8);
            levels.push(width);
        }

        // Fill in the nodes from the last one to the first, so that each comes after its parent.
        let first = self.nodes.len();
        let mut next = first + levels.iter().sum::<usize>();
        self.nodes.try_reserve(next - first)?;
        self.nodes.resize(next, Node::NO_CHILDREN);
        // Each iteration groups the children on one level into the nodes of the level above.
        let mut row = room(boxes.len())?;
        row.extend((self.boxed as u32..).zip(boxes).map(|(leaf, &bounds)| (LEAF | leaf, bounds)));
        for &width in &levels {
            let mut above = room(width)?;
            for children in row.chunks(8) {
                next -= 1;
                let mut around = Aabb::EMPTY;
                for (slot, &(child, bounds)) in children.iter().enumerate() {
                    self.nodes[next].set(slot, &bounds, child);
                    around.join(&bounds);
                }
                above.push((next as u32, around));
            }
            row = above;
        }
        self.thin_root = if levels.is_empty() { EMPTY } else { first as u32 };
        // The second root waits at the bottom of the stack while the main tree is traversed.
        self.stack = self.stack.max(Self::stack_for(1 + levels.len()));
        self.reach = self.find_reach();
        Ok(())
    }

    /// Returns the nodes of the main tree. The remaining nodes belong to the second tree.
    pub(crate) fn main_nodes(&self) -> &[Node] {
        &self.nodes[..self.nodes.len().min(self.thin_root as usize)]
    }

    /// Returns the stack size for a tree whose longest path has `depth` nodes.
    pub(crate) fn stack_for(depth: usize) -> usize {
        8 * depth + 8
    }

    /// Returns the box of the root.
    pub(crate) fn bounds(&self) -> Aabb {
        let mut around = Aabb::EMPTY;
        for slot in 0..8 {
            around.join(&self.nodes[0].bounds(slot));
        }
        around
    }

    /// Computes the largest coordinate magnitude of any triangle.
    pub(crate) fn find_reach(&self) -> f32 {
        // The boxes in the root nodes contain all triangles that have a box.
        let roots = [Some(&self.nodes[0]), self.nodes.get(self.thin_root as usize)];
        let sides = roots.into_iter().flatten().flat_map(|root| {
            (0..3).flat_map(|axis| [root.sides(axis, false), root.sides(axis, true)]).flatten()
        });
        sides.filter(|side| side.is_finite()).fold(0.0, |reach, x| reach.max(x.abs()))
    }

    /// Returns the triangle in a leaf slot.
    #[inline(always)]
    pub(crate) fn triangle_in(&self, LeafSlot(slot): LeafSlot) -> Triangle {
        self.leaves[slot as usize / 8].block.triangle(slot as usize % 8)
    }

    /// Returns the index of the triangle in a leaf slot.
    #[inline(always)]
    pub(crate) fn index_of(&self, LeafSlot(slot): LeafSlot) -> TriangleId {
        TriangleId(self.leaves[slot as usize / 8].indices[slot as usize % 8])
    }
}
