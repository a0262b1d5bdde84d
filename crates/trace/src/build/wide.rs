//! Writes the nodes and blocks of the planned wide tree, from the root down.

use super::binary::{Binary, Subtree};
use super::layout::Layout;
use crate::tree::{Aabb, BLOCK, EMPTY, LEAF, NONE, Node};
use crate::util::memory::NoMemory;
use crate::util::threads::join;

/// Subtrees with fewer triangles than this are each written by a single thread.
const PART: usize = 1 << 14;

/// A node still to be written: its subtree, its index, and its depth; the root's depth is 1.
#[derive(Clone, Copy)]
struct Task {
    part: Subtree,
    index: usize,
    depth: usize,
}

/// Writes the wide tree.
pub(super) fn write(binary: &Binary) -> Result<Layout, NoMemory> {
    // Write the top of the tree first, then the subtrees below it in parallel, each as a separate
    // tree.
    let mut below = Vec::new();
    let mut tree = write_part(binary, binary.root(), Some(&mut below))?;
    let parts = in_parts(binary, &below)?;
    tree.nodes.try_reserve_exact(parts.iter().map(|part| part.nodes.len()).sum())?;
    tree.blocks.try_reserve_exact(parts.iter().map(|part| part.blocks.len()).sum())?;

    // The root of each subtree fills the gap that was reserved for it. The other nodes of the
    // subtree are appended.
    for (task, part) in below.iter().zip(parts) {
        let (nodes, blocks) = (tree.nodes.len() as u32 - 1, tree.blocks.len() as u32);
        let mut moved = part.nodes.into_iter().map(|mut node| {
            for child in node.children_mut().iter_mut().filter(|child| **child != EMPTY) {
                // Each part numbers its nodes and blocks from 0. Because its root moves into the
                // gap, its other nodes shift by one less.
                *child += if *child & LEAF != 0 { blocks } else { nodes };
            }
            node
        });
        if let Some(root) = moved.next() {
            tree.nodes[task.index] = root;
        }
        tree.nodes.extend(moved);
        tree.blocks.extend(part.blocks);
        tree.depth = tree.depth.max(task.depth - 1 + part.depth);
    }
    Ok(tree)
}

/// Writes several parts in parallel.
fn in_parts(binary: &Binary, tasks: &[Task]) -> Result<Vec<Layout>, NoMemory> {
    if let [] | [_] = tasks {
        return tasks.iter().map(|task| write_part(binary, task.part, None)).collect();
    }
    let (a, b) = tasks.split_at(tasks.len() / 2);
    let (a, b) = join(|| in_parts(binary, a), || in_parts(binary, b));
    let (mut a, b) = (a?, b?);
    a.extend(b);
    Ok(a)
}

/// Writes the wide tree of a subtree. If `below` is given, subtrees smaller than [`PART`] are
/// pushed onto `below` instead.
fn write_part(
    binary: &Binary,
    root: Subtree,
    mut below: Option<&mut Vec<Task>>,
) -> Result<Layout, NoMemory> {
    let mut tree = Layout::empty();
    let mut tasks = vec![Task { part: root, index: 0, depth: 1 }];
    while let Some(task) = tasks.pop() {
        // Leave small subtrees to other threads and reserve a node for the root of each.
        if let Some(below) = &mut below
            && task.part.count < PART
        {
            below.push(task);
            continue;
        }
        tree.depth = tree.depth.max(task.depth);
        let (children, count) = children(binary, task.part);
        let children = &children[..count];
        let boxes: [Aabb; 8] =
            std::array::from_fn(|i| children.get(i).map_or(Aabb::EMPTY, |c| binary.bounds(*c)));
        let slots = slots(&boxes[..count]);
        // Write the blocks now, so that sibling blocks are adjacent. Sibling nodes also get
        // adjacent indices, but are filled later, first child first.
        tree.nodes.try_reserve(count)?;
        tree.blocks.try_reserve(count)?;
        let first = tree.nodes.len();
        for (i, child) in children.iter().enumerate() {
            let pointer = if binary.is_block(*child) {
                tree.blocks.push(block(binary, *child));
                (tree.blocks.len() - 1) as u32 | LEAF
            } else {
                tree.nodes.push(Node::NO_CHILDREN);
                (tree.nodes.len() - 1) as u32
            };
            tree.nodes[task.index].set(slots[i], &boxes[i], pointer);
        }
        let inner = children.iter().filter(|c| !binary.is_block(**c)).enumerate();
        let start = tasks.len();
        tasks.extend(inner.map(|(k, c)| Task {
            part: *c,
            index: first + k,
            depth: task.depth + 1,
        }));
        // The first child is popped next, so nodes end up in memory in the order in which rays
        // visit them.
        tasks[start..].reverse();
    }
    Ok(tree)
}

/// Returns the planned children of the wide node at the root of a subtree, and their number.
fn children(binary: &Binary, root: Subtree) -> ([Subtree; 8], usize) {
    let mut out = [root; 8];
    // Only the root of the whole tree can itself be a block. In that case, the block becomes the
    // only child of the wide root.
    if binary.is_block(root) {
        return (out, 1);
    }
    // Divide the eight slots depth first. Each waiting subtree is entitled to at least one slot, so
    // no more than eight subtrees wait at once.
    let mut count = 0;
    let mut waiting = [(root, 0); 8];
    let mut n = share(binary, root, 8, &mut waiting, 0);
    while n > 0 {
        n -= 1;
        let (part, places) = waiting[n];
        // Use fewer slots if that costs no more.
        let plan = binary.plan(part);
        let places = (2..=places).rev().find(|&i| plan.is_some_and(|p| p.left(i) > 0));
        if let Some(places) = places {
            n = share(binary, part, places, &mut waiting, n);
        } else {
            out[count] = part;
            count += 1;
        }
    }
    (out, count)
}

/// Pushes both sides of a subtree onto the waiting list, with the left side on top.
fn share(
    binary: &Binary,
    part: Subtree,
    places: usize,
    waiting: &mut [(Subtree, usize); 8],
    n: usize,
) -> usize {
    let left = binary.plan(part).map_or(0, |p| p.left(places));
    let [a, b] = binary.sides(part);
    // Push the left side last so that it is split first: children then come out in left-to-right
    // order.
    waiting[n] = (b, places - left);
    waiting[n + 1] = (a, left);
    n + 2
}

/// Returns the indices of a subtree's triangles in ascending order.
fn block(binary: &Binary, part: Subtree) -> [u32; BLOCK] {
    let mut block = [NONE; BLOCK];
    for (to, r) in block.iter_mut().zip(&binary.refs[part.first..part.first + part.count]) {
        *to = r.index();
    }
    block.sort_unstable();
    block
}

/// Builds a node whose children are up to eight leaves, given by their boxes and indices.
pub(super) fn leaf_node(boxes: &[(Aabb, u32)]) -> Node {
    let all: [Aabb; 8] =
        std::array::from_fn(|i| boxes.get(i).map_or(Aabb::EMPTY, |(bounds, _)| *bounds));
    let slots = slots(&all[..boxes.len()]);
    let mut node = Node::NO_CHILDREN;
    for ((bounds, number), slot) in boxes.iter().zip(slots) {
        node.set(slot, bounds, LEAF | number);
    }
    node
}

/// Assigns a slot to each child by octant. Rays of octant `s` visit slot `s` first, so that slot
/// gets the child closest to the side from which these rays come. Greedily picks the best remaining
/// pair of a child and a slot, as in Ylitie, Karras, and Laine (2017, section 3.3).
fn slots(boxes: &[Aabb]) -> [usize; 8] {
    let mut all = Aabb::EMPTY;
    for b in boxes {
        all.join(b);
    }
    let scale = all.scale();
    let middle = all.centre(scale);
    // Compute the position of each child along the mean ray direction of each slot.
    let mut along = [[0.0; 8]; 8];
    for (row, b) in along.iter_mut().zip(boxes) {
        // The bits of a slot number are the signs of a ray direction. Rays of octant o visit slot o
        // first, so slot o should hold the child that these rays reach first.
        let c = b.centre(scale);
        let [x, y, z] = [c[0] - middle[0], c[1] - middle[1], c[2] - middle[2]];
        *row = [
            x + y + z,
            y + z - x,
            x - y + z,
            z - x - y,
            x + y - z,
            y - x - z,
            x - y - z,
            -x - y - z,
        ];
    }
    let mut slots = [0; 8];
    let mut open = [true; 8];
    let mut waiting = (1_u32 << boxes.len()) - 1;
    while waiting != 0 {
        let (mut least, mut best) = (f32::INFINITY, (waiting.trailing_zeros() as usize, 0));
        for child in (0..boxes.len()).filter(|c| waiting >> c & 1 == 1) {
            for slot in 0..8 {
                // Greedy: take the best pair of child and slot, then the best of the rest.
                if open[slot] && along[child][slot] < least {
                    (least, best) = (along[child][slot], (child, slot));
                }
            }
        }
        let (child, slot) = best;
        slots[child] = slot;
        open[slot] = false;
        waiting &= !(1 << child);
    }
    slots
}
