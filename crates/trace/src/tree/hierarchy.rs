//! The hierarchy as the walk sees it: in f32.

use bytemuck::Zeroable;
use intertri::{Triangle, TriangleBlock};

use super::geometries::Geometries;
use super::leaf_bounds::LeafBounds;
use super::node::{NONE, Node};
use crate::memory::{NoMemory, room};

/// Up to eight triangles, in six cache lines.
#[derive(Clone, Copy, Debug, Zeroable)]
#[repr(C, align(64))]
pub(crate) struct Leaf {
    pub(crate) block: TriangleBlock<8>,
    /// Their indices in the order given.
    pub(crate) indices: [u32; 8],
}

const _: () = assert!(size_of::<Leaf>() == 384);

/// Nodes and leaves, of triangles or of their copies.
#[derive(Clone, Debug)]
pub struct Tree {
    /// The root is the first; a leaf of a node is the index of a block.
    pub(crate) nodes: Vec<Node>,
    /// The triangles, eight by eight.
    pub(crate) leaves: Vec<Leaf>,
    /// By leaf, the lanes of triangles without an area: their lanes are dead to rays, but closest points count them. Empty
    /// where there are none.
    pub(crate) degenerate: Vec<u8>,
    /// How many leaves, from the first, are in the nodes; the others are tested with every ray.
    pub(crate) boxed: usize,
    /// No coordinate of a triangle is larger.
    pub(crate) reach: f32,
    /// A stack of this size always suffices.
    pub(crate) stack: usize,
    pub(crate) triangles: usize,
    /// Which triangle is whose.
    pub(crate) geometries: Geometries,
    /// What it cost as built; known once it was refitted.
    pub(crate) cost_as_built: Option<f64>,
}

impl Tree {
    /// The triangles that have no place in the tree, ascending: they were not finite when it was built, or had no
    /// box.
    pub(crate) fn left_out(&self) -> Result<Vec<u32>, NoMemory> {
        let in_tree = || {
            let indices = self.leaves[..self.boxed].iter().flat_map(|leaf| leaf.indices);
            indices.filter(|&index| index != NONE)
        };
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

    /// The lanes of a leaf that have a triangle of their own, which is finite.
    #[inline(always)]
    pub(crate) fn present(&self, leaf: usize) -> u32 {
        let degenerate = self.degenerate.get(leaf).map_or(0, |&lanes| u32::from(lanes));
        self.leaves[leaf].block.live() | degenerate
    }

    /// Notes which lanes have no area; told by leaf, from the first.
    pub(crate) fn note_degenerate(&mut self, bounds: &[LeafBounds]) -> Result<(), NoMemory> {
        self.degenerate = Vec::new();
        if bounds.iter().any(|leaf| leaf.degenerate != 0) {
            self.degenerate = room(bounds.len())?;
            self.degenerate.extend(bounds.iter().map(|leaf| leaf.degenerate as u8));
        }
        Ok(())
    }

    /// The stack for a tree of so many nodes on its longest path.
    pub(crate) fn stack_for(depth: usize) -> usize {
        8 * depth + 8
    }

    /// No coordinate of a triangle is larger: of the boxes of the root, and of the leaves without a box.
    pub(crate) fn find_reach(&self) -> f32 {
        let root = &self.nodes[0];
        let sides = (0..3).flat_map(|axis| [root.sides(axis, false), root.sides(axis, true)]);
        let sides = sides.flatten().filter(|side| side.is_finite());
        let unboxed = self.leaves[self.boxed..].iter();
        let corners = unboxed.flat_map(|leaf| leaf.block.corners().as_flattened().as_flattened());
        sides.chain(corners).fold(0.0, |reach, x| reach.max(x.abs()))
    }

    /// The triangle in a place of the leaves.
    #[inline(always)]
    pub(crate) fn triangle_in(&self, place: u32) -> Triangle {
        self.leaves[place as usize / 8].block.triangle(place as usize % 8)
    }

    /// The index of the triangle in a place of the leaves.
    #[inline(always)]
    pub(crate) fn index_of(&self, place: u32) -> u32 {
        self.leaves[place as usize / 8].indices[place as usize % 8]
    }
}
