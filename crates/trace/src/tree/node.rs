//! A node of the tree: eight boxes in structure-of-arrays layout.

use bytemuck::Zeroable;

use super::aabb::Aabb;

/// The index that marks a missing child.
pub(crate) const EMPTY: u32 = u32::MAX;

/// The bit that marks a child as a block of triangles. The other bits are the block's index.
pub(crate) const LEAF: u32 = 1 << 31;

/// The maximum number of leaves. More leaves would need over 200 GB of memory.
pub(crate) const MOST_LEAVES: usize = 1 << 29;

/// The number of triangles in a block.
pub(crate) const BLOCK: usize = 8;

/// The index that marks an empty lane of a block.
pub(crate) const NONE: u32 = u32::MAX;

/// Eight children in structure-of-arrays layout: four cache lines, of which a slab test reads
/// three.
///
/// Children are assigned to slots by octant. A ray's octant `o` has bit `k` set if `dir[k] < 0`;
/// visiting slots in ascending order of `slot ^ o` then goes roughly front to back.
#[derive(Clone, Copy, Debug, Zeroable)]
#[repr(C, align(64))]
pub(crate) struct Node {
    /// Three rows of lower sides by axis, infinite for a missing child; three rows of upper sides,
    /// minus infinity for a missing child; the children, as bits ([`EMPTY`], [`LEAF`] with the
    /// index of a block, or the index of a node); and a row of [`EMPTY`].
    rows: [[f32; 8]; 8],
}

/// The first row of upper sides.
const UPPER: usize = 3;

/// The row of the children.
const CHILDREN: usize = 6;

impl Node {
    /// A node without children.
    pub(crate) const NO_CHILDREN: Self = {
        // The box is infinite and inverted: every ray leaves it before entering it, so empty slots
        // need no separate test.
        let (lo, hi) = ([f32::INFINITY; 8], [f32::NEG_INFINITY; 8]);
        let empty = [f32::from_bits(EMPTY); 8];
        Self { rows: [lo, lo, lo, hi, hi, hi, empty, empty] }
    };

    /// Returns the lower or upper sides along an axis.
    #[inline(always)]
    pub(crate) fn sides(&self, axis: usize, upper: bool) -> &[f32; 8] {
        // The remainder keeps the index in bounds for any axis.
        &self.rows[(axis + if upper { UPPER } else { 0 }) % 8]
    }

    /// Returns the children, indexed by slot.
    #[inline(always)]
    pub(crate) fn children(&self) -> &[u32; 8] {
        bytemuck::cast_ref(&self.rows[CHILDREN])
    }

    /// Returns the child in a slot, or [`EMPTY`] for the slot after the last.
    #[inline(always)]
    pub(crate) fn child_or_none(&self, slot: u8) -> u32 {
        // The row after the children is `EMPTY`. Slot 8, which means that no slot is selected,
        // therefore yields no child, without a branch.
        self.rows.as_flattened()[8 * CHILDREN..][usize::from(slot % 16)].to_bits()
    }

    /// Returns all rows of the node.
    pub(crate) fn rows(&self) -> &[[f32; 8]; 8] {
        &self.rows
    }

    /// Creates a node from its rows.
    pub(crate) fn of_rows(rows: [[f32; 8]; 8]) -> Self {
        Self { rows }
    }

    /// Like [`Node::children`], but returns floats for use in lanes.
    #[inline(always)]
    pub(crate) fn child_lanes(&self) -> &[f32; 8] {
        &self.rows[CHILDREN]
    }

    /// Returns a mutable reference to the children.
    pub(crate) fn children_mut(&mut self) -> &mut [u32; 8] {
        bytemuck::cast_mut(&mut self.rows[CHILDREN])
    }

    /// Puts a child into a slot. Subnormal sides are moved outward: multiplying a subnormal number
    /// can take a CPU hundreds of cycles, and in f64 scenes every corner at the centre would have
    /// such sides.
    pub(crate) fn set(&mut self, slot: usize, bounds: &Aabb, child: u32) {
        let bounds = bounds.without_subnormal_sides();
        for k in 0..3 {
            self.rows[k][slot] = bounds.lo[k];
            self.rows[k + UPPER][slot] = bounds.hi[k];
        }
        self.children_mut()[slot] = child;
    }

    /// Returns the box of the child in a slot.
    pub(crate) fn bounds(&self, slot: usize) -> Aabb {
        let side = |upper| {
            let of = |axis| self.sides(axis, upper)[slot];
            [of(0), of(1), of(2), 0.0]
        };
        Aabb { lo: side(false), hi: side(true) }
    }
}

const _: () = assert!(size_of::<Node>() == 256);

#[cfg(test)]
mod tests {
    use intertri::{Triangle64, TriangleOf};

    use crate::Bvh;
    use crate::tree::Tree;

    fn has_subnormal_sides(tree: &Tree) -> bool {
        let sides =
            |axis| tree.nodes.iter().flat_map(move |n| [n.sides(axis, false), n.sides(axis, true)]);
        (0..3).flat_map(sides).flatten().any(|x| x.is_subnormal())
    }

    /// Builds and refits an f64 sheet that has triangle corners at its centre.
    #[test]
    fn sides_are_not_subnormal() {
        let cell = |i: i32, j: i32| -> Triangle64 {
            let at = |i: i32, j: i32| [f64::from(i), f64::from(j), 0.0];
            TriangleOf([at(i, j), at(i + 1, j), at(i, j + 1)])
        };
        let sheet: Vec<_> = (0..400).map(|n| cell(n / 20 - 10, n % 20 - 10)).collect();
        let mut bvh = Bvh::new(&sheet).unwrap();
        assert!(!has_subnormal_sides(&bvh.tree));
        bvh.refit(&sheet).unwrap();
        assert!(!has_subnormal_sides(&bvh.tree));
    }
}
