//! Checks that nodes, leaves, and triangle indices are consistent.
//!
//! A hierarchy that passes these checks returns correct results for the triangles in its leaves:
//! every child exists and has exactly one parent, every box contains its contents with the padding
//! that needles need, and no index occurs twice.

use super::error::LoadError;
use crate::build::MAX_DEPTH;
use crate::tree::{Aabb, EMPTY, Geometries, LEAF, Leaf, LeafBounds, NONE, Node};
use crate::util::memory::{NoMemory, room};
use crate::util::threads;

/// Checks that nodes and leaves form a tree, and returns its depth. Each node except the first must
/// come after its only parent, and each leaf must have exactly one parent.
pub(super) fn tree(nodes: &[Node], boxed: usize) -> Result<usize, LoadError> {
    let (mut depths, mut leaves) = (zeros::<u8>(nodes.len())?, zeros::<bool>(boxed)?);
    let wrong = LoadError::damaged("its nodes do not form a tree");
    if let Some(root) = depths.first_mut() {
        *root = 1;
    }
    // Depth 0 marks a node that has not yet been found to be a child.
    let (mut deepest, mut count) = (0, 0);
    for (i, node) in nodes.iter().enumerate() {
        let depth = depths[i];
        deepest = deepest.max(depth);
        for &child in node.children().iter().filter(|&&child| child != EMPTY) {
            let index = (child & !LEAF) as usize;
            if child & LEAF == 0 {
                match depths.get_mut(index) {
                    // A child must come after its parent and have only one parent, which rules out
                    // cycles. Nodes without a parent are rejected too.
                    Some(below) if index > i && *below == 0 && depth > 0 => *below = depth + 1,
                    _ => return wrong,
                }
            } else {
                match leaves.get_mut(index) {
                    Some(seen) if !*seen && depth > 0 => *seen = true,
                    _ => return wrong,
                }
                count += 1;
            }
        }
        if depth == 0 || usize::from(depth) > MAX_DEPTH {
            return wrong;
        }
    }
    if deepest == 0 || count != boxed { wrong } else { Ok(deepest.into()) }
}

/// Restores the geometries from their triangle counts and masks. The counts must add up to the
/// total number of triangles.
pub(super) fn geometries(all: &[(u32, u32)], triangles: u64) -> Result<Geometries, LoadError> {
    let counts = all.iter().map(|&(count, _)| count as usize);
    if counts.clone().map(|count| count as u64).sum::<u64>() != triangles {
        return LoadError::damaged("its geometries do not match its triangles");
    }
    let mut geometries = match all {
        [_] => Geometries::one(),
        _ => Geometries::of(counts)?,
    };
    geometries.set_masks(all.iter().map(|&(_, mask)| mask));
    Ok(geometries)
}

/// Checks that every box contains its contents, and that the main tree contains no needles: no box
/// bounds the hits on a needle.
pub(super) fn boxes(nodes: &[Node], leaves: &[LeafBounds]) -> Result<(), LoadError> {
    let is_in = |inner: &Aabb, outer: &Aabb| {
        (0..3).all(|k| outer.lo[k] <= inner.lo[k] && inner.hi[k] <= outer.hi[k])
    };
    // Compare the sides of all eight boxes at once, in SIMD lanes.
    let are_in = |node: &Node, outer: &Aabb| {
        (0..3).all(|k| {
            let least = node.sides(k, false).iter().fold(f32::INFINITY, |least, &x| least.min(x));
            let most = node.sides(k, true).iter().fold(f32::NEG_INFINITY, |most, &x| most.max(x));
            outer.lo[k] <= least && most <= outer.hi[k]
        })
    };
    let holds = |node: &Node| {
        (0..8).filter(|&slot| node.children()[slot] != EMPTY).all(|slot| {
            let (bounds, child) = (node.bounds(slot), node.children()[slot]);
            if child & LEAF == 0 {
                return are_in(&nodes[child as usize], &bounds);
            }
            // Needles must not be in the main tree, because no box bounds the hits on them.
            let leaf = &leaves[(child & !LEAF) as usize];
            leaf.thin == 0 && is_in(&leaf.bounds, &bounds)
        })
    };
    if threads::all(nodes, holds) { Ok(()) } else { LoadError::damaged("a box is too small") }
}

/// Checks that each triangle occurs exactly once: either in the tree or in the list of omitted
/// triangles. Also checks that no triangle without a box is live in the tree or listed twice.
pub(super) fn numbers(
    leaves: &[Leaf],
    boxed: usize,
    left_out: &[u32],
    triangles: usize,
) -> Result<(), LoadError> {
    let wrong = LoadError::damaged("the numbers of its triangles are invalid");
    let (tree, unboxed) = leaves.split_at(boxed);
    // One bit per triangle, set when the triangle is found.
    let mut seen = zeros::<u64>(triangles.div_ceil(64))?;
    let mut is_new = |index: u32| {
        let (word, bit) = (&mut seen[index as usize / 64], 1 << (index % 64));
        let new = *word & bit == 0;
        // If the bit is already set, the triangle occurs twice.
        *word |= bit;
        new
    };
    let mut once = true;
    for leaf in tree {
        for &index in leaf.indices.iter().take_while(|&&index| index != NONE) {
            once &= is_new(index);
        }
    }
    for &index in left_out {
        once = once && (index as usize) < triangles && is_new(index);
    }
    // If each triangle occurs at most once, the number of bits set is the number of triangles
    // found.
    let found: usize = seen.iter().map(|word| word.count_ones() as usize).sum();
    if !once || found != triangles {
        return wrong;
    }
    if unboxed.is_empty() {
        return Ok(());
    }

    // Only two kinds of triangles may be listed without a box: those in the tree that cannot be
    // hit, and omitted ones.
    let mut away = zeros::<u64>(triangles.div_ceil(64))?;
    let silent = tree.iter().flat_map(|leaf| {
        let lanes = leaf.indices.iter().take_while(|&&index| index != NONE).count();
        let is_silent = |lane: &usize| leaf.block.live() >> lane & 1 == 0;
        (0..lanes).filter(is_silent).map(|lane| leaf.indices[lane])
    });
    for index in silent.chain(left_out.iter().copied()) {
        away[index as usize / 64] |= 1 << (index % 64);
    }
    for leaf in unboxed {
        for &index in leaf.indices.iter().take_while(|&&index| index != NONE) {
            let (word, bit) = (&mut away[index as usize / 64], 1 << (index % 64));
            once &= *word & bit != 0;
            *word &= !bit;
        }
    }
    if once { Ok(()) } else { wrong }
}

fn zeros<T: Default + Clone>(count: usize) -> Result<Vec<T>, NoMemory> {
    let mut all = room(count)?;
    all.resize(count, T::default());
    Ok(all)
}
