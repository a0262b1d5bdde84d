//! The result of the builder: nodes, and blocks of triangle indices.

use crate::tree::{BLOCK, Node};
#[cfg(test)]
use {
    super::collapse,
    crate::tree::{Aabb, EMPTY, LEAF},
};

/// The maximum number of nodes on a path from the root, for any triangles.
pub(crate) const MAX_DEPTH: usize = 64;

/// The hierarchy over a slice of triangles. It stores indices of triangles, not the triangles.
#[derive(Debug, Default)]
pub(crate) struct Layout {
    /// The nodes, starting with the root. Those children of a node that are themselves nodes are
    /// adjacent.
    pub nodes: Vec<Node>,
    /// Triangle indices, ascending, padded with [`crate::tree::NONE`].
    pub blocks: Vec<[u32; BLOCK]>,
    /// The number of nodes on the longest path from the root, at least 1 and at most [`MAX_DEPTH`].
    pub depth: usize,
    /// The largest distance outside its box at which the reference implementation may report a hit
    /// on a triangle in the blocks.
    pub lean: f32,
    /// Thin triangles, in ascending order. The reference implementation may report hits on them
    /// arbitrarily far outside their boxes, so they are in no block.
    pub thin: Vec<u32>,
    /// Whether any triangle in a block is degenerate.
    pub has_degenerate: bool,
}

impl Layout {
    /// Creates a layout without triangles.
    pub(crate) fn empty() -> Self {
        Self { nodes: vec![Node::NO_CHILDREN], depth: 1, ..Self::default() }
    }
}

#[cfg(test)]
impl Layout {
    /// Returns the surface-area cost: the expected cost of a random line through the root's box, in
    /// units of one node visit.
    pub(crate) fn cost(&self) -> f64 {
        let mut root = Aabb::EMPTY;
        let children =
            |node: &Node| (0..8).filter(|&i| node.children()[i] != EMPTY).collect::<Vec<_>>();
        for i in children(&self.nodes[0]) {
            root.join(&self.nodes[0].bounds(i));
        }
        let scale = root.scale();
        let mut sum = root.half_area(scale) as f64 * collapse::NODE as f64;
        for node in &self.nodes {
            for i in children(node) {
                let price =
                    if node.children()[i] & LEAF == 0 { collapse::NODE } else { collapse::LEAF };
                sum += node.bounds(i).half_area(scale) as f64 * price as f64;
            }
        }
        sum / root.half_area(scale) as f64
    }
}
