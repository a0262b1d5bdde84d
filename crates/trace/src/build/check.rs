//! Checks that a tree is well formed. The check is slow and is used only in tests.

use super::layout::{Layout, MAX_DEPTH};
use crate::tree::{Aabb, BLOCK, EMPTY, HitBounds, LEAF, NONE, hit_bounds};
use intertri::Triangle;

impl Layout {
    /// Traverses the whole tree. Returns an error message if a triangle that has a box is not in
    /// exactly one block, or a triangle that has none is in a block; if a box is not the tight
    /// bound of its contents; if a node or block does not have exactly one parent; or if the depth
    /// differs from the stored depth.
    pub(crate) fn check(&self, triangles: &[Triangle]) -> Result<(), String> {
        let mut walk = Walk {
            tree: self,
            triangles,
            seen: vec![0; triangles.len()],
            blocks: vec![0; self.blocks.len()],
            nodes: vec![0; self.nodes.len()],
            depth: 0,
        };
        // Count every node and block when it is reached, from the root down. The counts reveal any
        // child that is missing, has two parents, or is part of a cycle.
        walk.node(0, 1)?;
        // Triangles with a box are in exactly one block. Other triangles are never hit, or are in
        // leaves of the second tree.
        let expected = |t: &Triangle| {
            let bounds = hit_bounds(t);
            u32::from(matches!(bounds, HitBounds::Box { .. } | HitBounds::Degenerate(_)))
        };
        for (i, (&seen, t)) in walk.seen.iter().zip(triangles).enumerate() {
            if seen != expected(t) {
                return Err(format!("triangle {i} is in {seen} blocks"));
            }
        }
        if walk.blocks.iter().chain(&walk.nodes).any(|&n| n != 1) {
            return Err("a node or block does not have exactly one parent".into());
        }
        if walk.depth != self.depth || self.depth > MAX_DEPTH {
            return Err(format!("depth {} is stored as {}", walk.depth, self.depth));
        }
        Ok(())
    }
}

struct Walk<'a> {
    tree: &'a Layout,
    triangles: &'a [Triangle],
    seen: Vec<u32>,
    blocks: Vec<u32>,
    nodes: Vec<u32>,
    depth: usize,
}

impl Walk<'_> {
    fn node(&mut self, index: usize, depth: usize) -> Result<Aabb, String> {
        self.nodes[index] += 1;
        self.depth = self.depth.max(depth);
        // Check the depth before the recursion, which would never end in a cycle.
        if depth > MAX_DEPTH {
            return Err(format!("node {index} is {depth} deep"));
        }
        let node = &self.tree.nodes[index];
        let (mut all, mut next) = (Aabb::EMPTY, None);
        for slot in 0..8 {
            let content = match node.children()[slot] {
                EMPTY => Aabb { lo: [f32::INFINITY; 4], hi: [f32::NEG_INFINITY; 4] },
                leaf if leaf & LEAF != 0 => self.block((leaf & !LEAF) as usize)?,
                child => {
                    // Children are adjacent, so no two are more than seven apart.
                    let base = *next.get_or_insert(child);
                    if base.abs_diff(child) > 7 || child as usize <= index {
                        return Err(format!("node {child} is not beside {base}"));
                    }
                    self.node(child as usize, depth + 1)?
                }
            };
            let (bounds, sides) = (node.bounds(slot), content.without_subnormal_sides());
            // Test for equality, not only for containment: a box that is too large does not change
            // any result, so no other test would notice it.
            if (0..3).any(|k| bounds.lo[k] != sides.lo[k] || bounds.hi[k] != sides.hi[k]) {
                return Err(format!("node {index} slot {slot}: {bounds:?} around {content:?}"));
            }
            all.join(&content);
        }
        Ok(all)
    }

    fn block(&mut self, index: usize) -> Result<Aabb, String> {
        self.blocks[index] += 1;
        let block: &[u32; BLOCK] = &self.tree.blocks[index];
        let full = block.iter().take_while(|&&i| i != NONE).count();
        let ascends = block[..full].windows(2).all(|w| w[0] < w[1]);
        // The order of a block's triangles must not depend on how the build ran, or equal trees
        // would have different bytes.
        if full == 0 || !ascends || block[full..].iter().any(|&i| i != NONE) {
            return Err(format!("block {index} is {block:?}"));
        }
        let mut all = Aabb::EMPTY;
        for &i in &block[..full] {
            self.seen[i as usize] += 1;
            if let HitBounds::Box { bounds, .. } | HitBounds::Degenerate(bounds) =
                hit_bounds(&self.triangles[i as usize])
            {
                all.join(&bounds);
            }
        }
        Ok(all)
    }
}
