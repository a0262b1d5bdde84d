//! Whether a point lies on a triangle of a hierarchy.

use intertri::internal::exact::is_on;

use crate::across::lanes_of;
use crate::tree::{Bvh, EMPTY, LEAF};

/// Whether a point lies on a triangle, exactly.
pub(crate) fn is_on_surface(bvh: &Bvh, point: [f32; 3]) -> bool {
    let leaf = |i: usize| {
        let block = &bvh.leaves[i].block;
        lanes_of(block.live()).any(|lane| is_on(&block.triangle(lane), point))
    };

    // The boxes that hold it. There is always room on the stack for what a node adds.
    let mut stack = vec![0];
    while let Some(node) = stack.pop() {
        let Some(node) = bvh.nodes.get(node as usize) else { continue };
        for (slot, &child) in node.children().iter().enumerate() {
            let holds = |axis: usize| {
                let (lo, hi) = (node.sides(axis, false)[slot], node.sides(axis, true)[slot]);
                lo <= point[axis] && point[axis] <= hi
            };
            if child == EMPTY || !(0..3).all(holds) {
                continue;
            }
            if child & LEAF == 0 {
                stack.push(child);
            } else if leaf((child & !LEAF) as usize) {
                return true;
            }
        }
    }
    (bvh.boxed..bvh.leaves.len()).any(leaf)
}
