//! Converts nodes and leaves to and from bytes.
//!
//! ```text
//!   node   8 rows of 8 f32: lower x y z, upper x y z, children as bits, `EMPTY`
//!   leaf   3 corners of 3 rows of 8 f32: x y z; 8 u32: the triangles' indices
//! ```
//!
//! An index with its highest bit set belongs to a triangle that cannot be hit. Such a triangle
//! either is degenerate and is stored with its own corners or, in a refitted hierarchy, is
//! currently not finite and is stored with the corners of another, nondegenerate triangle. If all
//! bits are set, the lane holds no triangle.

use intertri::TriangleBlock;
use intertri::simd::{Simd, WithSimd};

use super::format::{LEAF_SIZE, NODE};
use crate::tree::{EMPTY, LaneBounds, Leaf, LeafBounds, NONE, Node};

/// The bit that marks the index of a triangle that cannot be hit.
const SILENT: u32 = 1 << 31;

/// Writes a node.
pub(super) fn write_node(node: &Node, to: &mut [u8]) {
    for (to, x) in to.chunks_exact_mut(4).zip(node.rows().as_flattened()) {
        to.copy_from_slice(&x.to_bits().to_le_bytes());
    }
}

/// Writes a leaf.
pub(super) fn write_leaf(leaf: &Leaf, to: &mut [u8]) {
    let corners = leaf.block.corners().as_flattened().as_flattened().iter().map(|x| x.to_bits());
    for (to, x) in to.chunks_exact_mut(4).zip(corners.chain(numbers_to_write(leaf))) {
        to.copy_from_slice(&x.to_le_bytes());
    }
}

/// Returns the indices of a leaf's triangles as they are stored.
pub(super) fn numbers_to_write(leaf: &Leaf) -> impl Iterator<Item = u32> + '_ {
    let live = leaf.block.live();
    let number = move |lane: usize| {
        let silent = if live >> lane & 1 == 0 { SILENT } else { 0 };
        leaf.indices[lane] | silent
    };
    (0..8).map(number)
}

/// Decodes the indices of a leaf and a mask of its live triangles. There must be at least one
/// index, and indices must be in ascending order and below `triangles`.
#[inline(always)]
pub(super) fn read_numbers(mut indices: [u32; 8], triangles: u32) -> Option<([u32; 8], u32)> {
    let (mut live, mut sound, mut next) = (0, indices[0] != NONE, 0);
    for (lane, index) in indices.iter_mut().enumerate() {
        if *index == NONE {
            // No index may follow a lane without a triangle.
            next = SILENT;
            continue;
        }
        // As in a newly built leaf, indices must ascend, with gaps only at the end.
        live |= u32::from(*index & SILENT == 0) << lane;
        *index &= !SILENT;
        sound &= *index >= next && *index < triangles;
        next = (*index + 1).max(next);
    }
    sound.then_some((indices, live))
}

/// Returns the lanes that have an index but are not live.
#[inline(always)]
pub(super) fn silent_lanes(indices: &[u32; 8], live: u32) -> u32 {
    let numbered = indices.iter().take_while(|&&index| index != NONE).count();
    ((1_u32 << numbered) - 1) & !live
}

/// Returns the 32-bit words of a record.
#[inline(always)]
fn words<const N: usize>(bytes: &[u8]) -> [u32; N] {
    let mut words = [0; N];
    for (word, bytes) in words.iter_mut().zip(bytes.as_chunks::<4>().0) {
        *word = u32::from_le_bytes(*bytes);
    }
    words
}

/// Reads a node. Returns whether the node is valid; the child indices are checked later.
pub(super) fn read_node(bytes: &[u8], node: &mut Node) -> bool {
    let words: [u32; NODE / 4] = words(bytes);
    let rows: [[f32; 8]; 8] = bytemuck::cast(words);
    // The last row is always empty; traversal reads it when no slot is selected.
    let mut sound = words[56..] == [EMPTY; 8];
    for slot in 0..8 {
        for axis in 0..3 {
            let (lo, hi) = (rows[axis][slot], rows[axis + 3][slot]);
            let is_box = lo <= hi && lo.is_finite() && hi.is_finite();
            // An inverted box marks an empty slot, or a child whose triangles cannot be hit.
            let is_none = lo == f32::INFINITY && hi == f32::NEG_INFINITY;
            sound &= is_none || is_box && words[48 + slot] != EMPTY;
        }
    }
    *node = Node::of_rows(rows);
    sound
}

/// Reads leaves and computes their bounds. Returns whether they are valid: all corners are finite,
/// and there is at least one index, in ascending order and below `triangles`.
pub(super) struct ReadLeaves<'a> {
    pub bytes: &'a [u8],
    pub triangles: u32,
    pub leaves: &'a mut [Leaf],
    pub bounds: &'a mut [LeafBounds],
}

impl WithSimd for ReadLeaves<'_> {
    type Output = bool;

    #[inline(always)]
    fn run<S: Simd>(self) -> bool {
        let Self { bytes, triangles, leaves, bounds } = self;
        for ((bytes, leaf), bounds) in bytes.chunks_exact(LEAF_SIZE).zip(leaves).zip(bounds) {
            let words: [u32; LEAF_SIZE / 4] = words(bytes);
            let mut indices = [0; 8];
            indices.copy_from_slice(&words[72..]);
            let Some((indices, live)) = read_numbers(indices, triangles) else { return false };

            let mut corners = [[[0.0; 8]; 3]; 3];
            let flat = corners.as_flattened_mut().as_flattened_mut();
            let mut finite = true;
            for (x, &bits) in flat.iter_mut().zip(&words) {
                *x = f32::from_bits(bits);
                finite &= bits & f32::INFINITY.to_bits() != f32::INFINITY.to_bits();
            }
            if !finite {
                return false;
            }
            *leaf = Leaf { block: TriangleBlock::of_lanes_in::<S>(corners, live), indices };
            *bounds = LaneBounds::of(&leaf.block).run::<S>();
            // A triangle that cannot be hit is either degenerate, which is determined here, or
            // currently not finite.
            bounds.add_degenerate(&corners, silent_lanes(&indices, live));
        }
        true
    }
}
