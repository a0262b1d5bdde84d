//! The node: eight boxes side by side.

use crate::bounds::Bounds;

/// The child that is not there.
pub(crate) const EMPTY: u32 = u32::MAX;

/// Marks a child that is a block of triangles; the other bits are the block's index.
pub(crate) const LEAF: u32 = 1 << 31;

/// The index of no triangle, in the empty places of a block.
pub(crate) const NONE: u32 = u32::MAX;

/// Eight children in structure-of-arrays order: four cache lines, of which a slab test reads three.
///
/// Children sit in slots by octant: for a ray whose octant `o` has bit `k` set where `dir[k] < 0`,
/// the slots in ascending order of `slot ^ o` go roughly from front to back.
#[derive(Clone, Copy, Debug)]
#[repr(C, align(64))]
pub(crate) struct Node {
    /// Lower sides by axis and slot; infinite where there is no child.
    pub lo: [[f32; 8]; 3],
    /// Upper sides; minus infinity where there is no child.
    pub hi: [[f32; 8]; 3],
    /// [`EMPTY`], or [`LEAF`] with the index of a block, or the index of a node.
    pub child: [u32; 8],
}

impl Node {
    /// No child at all.
    pub(crate) const NO_CHILDREN: Self =
        Self { lo: [[f32::INFINITY; 8]; 3], hi: [[f32::NEG_INFINITY; 8]; 3], child: [EMPTY; 8] };

    /// Puts a child into a slot.
    pub(crate) fn set(&mut self, slot: usize, bounds: &Bounds, child: u32) {
        for k in 0..3 {
            self.lo[k][slot] = bounds.lo[k];
            self.hi[k][slot] = bounds.hi[k];
        }
        self.child[slot] = child;
    }

    /// The box of the child in a slot.
    #[cfg(test)]
    pub(crate) fn bounds(&self, slot: usize) -> Bounds {
        let side = |s: &[[f32; 8]; 3]| [s[0][slot], s[1][slot], s[2][slot], 0.0];
        Bounds { lo: side(&self.lo), hi: side(&self.hi) }
    }
}

const _: () = assert!(size_of::<Node>() == 256);
