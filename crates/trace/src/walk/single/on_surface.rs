//! Tests whether a point is on a triangle of a hierarchy.

use intertri::LeafSlot;

use crate::tree::{EMPTY, LEAF, Tree};
use crate::util::lane_ops::lanes_of;

/// Returns whether a point lies on a triangle. Tests only triangles in leaves whose boxes contain
/// the point.
pub(crate) fn is_held(tree: &Tree, point: [f32; 3], is_on: impl Fn(LeafSlot) -> bool) -> bool {
    let leaf = |i: usize| {
        let mut lanes = lanes_of(tree.leaves[i].block.live());
        lanes.any(|lane| is_on(LeafSlot((8 * i + lane) as u32)))
    };

    // Visit the boxes that contain the point.
    let mut stack = vec![0, tree.thin_root];
    while let Some(node) = stack.pop() {
        let Some(node) = tree.nodes.get(node as usize) else { continue };
        for (slot, &child) in node.children().iter().enumerate() {
            // Boxes include their sides, because a point on a side may lie on a triangle in the
            // box.
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
    false
}
