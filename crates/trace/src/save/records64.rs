//! What a hierarchy over f64 has in place of leaves of f32, as bytes.
//!
//! ```text
//!   frame  the centre x y z (f64), the exponent of the scale (i32), zero (u32)
//!   leaf   3 corners of 3 rows of 8 f64: x y z; 8 u32: the triangles' numbers, as for f32
//! ```
//!
//! Copies are not written down: they are computed from the corners as a build computes them.

use bytemuck::Zeroable;
use intertri::internal::{Bits, LocalFrame};
use intertri::{Triangle64, TriangleBlock, TriangleOf};

use super::error::LoadError;
use super::format::u32_at;
use super::records::{numbers_to_write, read_numbers};
use crate::across::lanes_of;
use crate::tree::{Aabb, Leaf, LeafBounds, NONE};

/// The centre of a frame, and the exponent of its scale.
pub(super) type Frame = ([f64; 3], i32);

/// A leaf as it is written.
#[derive(Clone, Copy, Zeroable)]
pub(super) struct Leaf64 {
    corners: [[[f64; 8]; 3]; 3],
    pub(super) indices: [u32; 8],
    pub(super) live: u32,
}

impl Leaf64 {
    /// A leaf of no triangle.
    pub(super) const NONE: Self = Self { corners: [[[0.0; 8]; 3]; 3], indices: [NONE; 8], live: 0 };

    /// The triangle in a lane.
    pub(super) fn triangle(&self, lane: usize) -> Triangle64 {
        let corner = |k: usize| [0, 1, 2].map(|axis| self.corners[k][axis][lane]);
        TriangleOf([corner(0), corner(1), corner(2)])
    }

    /// The leaf of copies.
    pub(super) fn leaf(&self, frame: &LocalFrame) -> Leaf {
        let copies: [_; 8] = std::array::from_fn(|lane| frame.triangle(&self.triangle(lane)));
        Leaf { block: TriangleBlock::of_copies(&copies).keeping(self.live), indices: self.indices }
    }

    /// Where its triangles can be hit, whether they have an area or not.
    pub(super) fn bounds(&self, frame: &LocalFrame) -> LeafBounds {
        let mut around = Aabb::EMPTY;
        for lane in lanes_of(self.live) {
            if let Some([lo, hi]) = frame.bounds(&self.triangle(lane)) {
                let [lo, hi] = [lo, hi].map(|[x, y, z]| [x, y, z, 0.0]);
                around.join(&Aabb { lo, hi });
            }
        }
        LeafBounds { bounds: around, boxed: self.live, unbounded: 0 }
    }
}

/// Writes a frame down.
pub(super) fn write_frame((centre, up): Frame, to: &mut [u8]) {
    for (to, x) in to.chunks_exact_mut(8).zip(centre) {
        to.copy_from_slice(&x.to_bits().to_le_bytes());
    }
    to[24..28].copy_from_slice(&up.to_le_bytes());
}

/// Writes a leaf down. Lanes without a triangle repeat one, or are zeros.
pub(super) fn write_leaf64(leaf: &Leaf, triangles: &[Triangle64], to: &mut [u8]) {
    let live = leaf.block.live();
    let first = lanes_of(live).next();
    let corners = (0..9).flat_map(|row| (0..8).map(move |lane| (row / 3, row % 3, lane)));
    let (rows, numbers) = to.split_at_mut(9 * 64);
    for (to, (corner, axis, lane)) in rows.chunks_exact_mut(8).zip(corners) {
        let some = if live >> lane & 1 != 0 { Some(lane) } else { first };
        let x = some.map_or(0.0, |lane| triangles[leaf.indices[lane] as usize].0[corner][axis]);
        to.copy_from_slice(&x.to_bits().to_le_bytes());
    }
    for (to, number) in numbers.chunks_exact_mut(4).zip(numbers_to_write(leaf)) {
        to.copy_from_slice(&number.to_le_bytes());
    }
}

/// Reads a frame. Whether there may be such a one is seen when all corners are there.
pub(super) fn read_frame(bytes: &[u8]) -> Result<Frame, LoadError> {
    if u32_at(bytes, 28) != 0 {
        return LoadError::damaged("its frame makes no sense");
    }
    Ok(([0, 8, 16].map(|at| f64_at(bytes, at)), u32_at(bytes, 24) as i32))
}

fn f64_at(bytes: &[u8], at: usize) -> f64 {
    f64::from_bits(u64::from(u32_at(bytes, at)) | u64::from(u32_at(bytes, at + 4)) << 32)
}

/// Reads a leaf: finite corners, and numbers as a leaf of f32 has them.
pub(super) fn read_leaf64(bytes: &[u8], triangles: u32) -> Option<Leaf64> {
    let numbers: [u32; 8] = std::array::from_fn(|lane| u32_at(bytes, 9 * 64 + 4 * lane));
    let (indices, live) = read_numbers(numbers, triangles)?;
    let mut leaf = Leaf64 { indices, live, ..Leaf64::NONE };
    let flat = leaf.corners.as_flattened_mut().as_flattened_mut();
    let mut finite = true;
    for (x, bytes) in flat.iter_mut().zip(bytes.as_chunks::<8>().0) {
        *x = f64::from_bits(u64::from_le_bytes(*bytes));
        finite &= Bits::is_finite(*x);
    }
    finite.then_some(leaf)
}
