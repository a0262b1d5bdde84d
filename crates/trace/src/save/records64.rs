//! Converts the frame and the leaves of f64 hierarchies to and from bytes.
//!
//! ```text
//!   frame  the centre x y z (f64), the exponent of the scale (i32), zero (u32)
//!   leaf   3 corners of 3 rows of 8 f64: x y z; 8 u32: the triangles' indices, as for f32
//! ```
//!
//! Copies are not stored: the loader recomputes them from the corners, as a build does.

use intertri::internal::LocalFrame;
use intertri::internal::exact::has_area;
use intertri::simd::{Simd, WithSimd};
use intertri::{Triangle64, TriangleOf};

use super::error::LoadError;
use super::format::{LEAF64_SIZE, u32_at};
use super::records::{numbers_to_write, read_numbers, silent_lanes};
use crate::tree::{Aabb, Leaf, LeafBounds};
use crate::util::lane_ops::lanes_of;

/// The triangles of a leaf.
pub(crate) type EightTriangles = [Triangle64; 8];

/// Writes a frame.
pub(super) fn write_frame(frame: &LocalFrame, to: &mut [u8]) {
    let (centre, up) = frame.centre_and_exponent();
    for (to, x) in to.chunks_exact_mut(8).zip(centre) {
        to.copy_from_slice(&x.to_bits().to_le_bytes());
    }
    to[24..28].copy_from_slice(&up.to_le_bytes());
}

/// Writes a leaf, in which some lanes may hold degenerate triangles. Lanes without a triangle
/// repeat a live triangle or, if no triangle is live, a nondegenerate dummy.
pub(super) fn write_leaf64(leaf: &Leaf, present: u32, triangles: &EightTriangles, to: &mut [u8]) {
    let first = lanes_of(leaf.block.live()).next();
    let corners = (0..9).flat_map(|row| (0..8).map(move |lane| (row / 3, row % 3, lane)));
    let (rows, numbers) = to.split_at_mut(9 * 64);
    for (to, (corner, axis, lane)) in rows.chunks_exact_mut(8).zip(corners) {
        // Lanes without a triangle get deterministic contents, so that equal hierarchies are saved
        // as equal bytes.
        let some = if present >> lane & 1 != 0 { Some(lane) } else { first };
        let any = if corner == axis { 1.0_f64 } else { 0.0 };
        let x = some.map_or(any, |lane| triangles[lane].0[corner][axis]);
        to.copy_from_slice(&x.to_bits().to_le_bytes());
    }
    for (to, number) in numbers.chunks_exact_mut(4).zip(numbers_to_write(leaf)) {
        to.copy_from_slice(&number.to_le_bytes());
    }
}

/// Reads a frame. Its reach is computed later from the corners.
pub(super) fn read_frame(bytes: &[u8]) -> Result<LocalFrame, LoadError> {
    let (centre, up) = ([0, 8, 16].map(|at| f64_at(bytes, at)), u32_at(bytes, 24) as i32);
    match LocalFrame::of(centre, up, [0.0; 3]) {
        Some(frame) if u32_at(bytes, 28) == 0 => Ok(frame),
        _ => LoadError::damaged("its frame is invalid"),
    }
}

fn f64_at(bytes: &[u8], at: usize) -> f64 {
    f64::from_bits(u64::from(u32_at(bytes, at)) | u64::from(u32_at(bytes, at + 4)) << 32)
}

/// Reads f64 leaves: the leaves of their copies, the bounds of the copies, and the original
/// triangles. Returns whether the leaves are valid: all corners are finite, and the indices meet
/// the same conditions as in f32 leaves.
pub(super) struct ReadLeaves64<'a> {
    pub bytes: &'a [u8],
    pub triangles: u32,
    pub frame: &'a LocalFrame,
    pub leaves: &'a mut [Leaf],
    pub bounds: &'a mut [LeafBounds],
    pub originals: &'a mut [EightTriangles],
}

impl WithSimd for ReadLeaves64<'_> {
    type Output = bool;

    #[inline(always)]
    fn run<S: Simd>(self) -> bool {
        let Self { bytes, triangles, frame, leaves, bounds, originals } = self;
        let to = leaves.iter_mut().zip(bounds).zip(originals);
        for (bytes, ((leaf, bounds), originals)) in bytes.chunks_exact(LEAF64_SIZE).zip(to) {
            let (rows, numbers) = bytes.split_at(9 * 64);
            let mut indices = [0; 8];
            for (number, bytes) in indices.iter_mut().zip(numbers.as_chunks::<4>().0) {
                *number = u32::from_le_bytes(*bytes);
            }
            let Some((indices, live)) = read_numbers(indices, triangles) else { return false };

            let mut corners = [[[0.0; 8]; 3]; 3];
            let flat = corners.as_flattened_mut().as_flattened_mut();
            let mut finite = true;
            for (x, bytes) in flat.iter_mut().zip(rows.as_chunks::<8>().0) {
                let bits = u64::from_le_bytes(*bytes);
                *x = f64::from_bits(bits);
                // Only infinities and NaN have all exponent bits set.
                finite &= bits & f64::INFINITY.to_bits() != f64::INFINITY.to_bits();
            }
            if !finite {
                return false;
            }
            // Recompute which triangles are degenerate instead of trusting the file.
            let degenerate = degenerate(&corners, silent_lanes(&indices, live));
            *leaf = Leaf { block: frame.block_in::<S>(&corners, live), indices };
            let [[a, b, c], [x, y, z]] = frame.bounds_in::<S>(&corners, live | degenerate);
            let around = Aabb { lo: [a, b, c, 0.0], hi: [x, y, z, 0.0] };
            *bounds = LeafBounds { bounds: around, boxed: live, degenerate, ..LeafBounds::NONE };
            for (lane, TriangleOf(triangle)) in originals.iter_mut().enumerate() {
                for (to, from) in triangle.iter_mut().zip(&corners) {
                    *to = [from[0][lane], from[1][lane], from[2][lane]];
                }
            }
        }
        true
    }
}

/// Returns a mask of those of the given lanes whose triangles are degenerate.
fn degenerate(corners: &[[[f64; 8]; 3]; 3], lanes: u32) -> u32 {
    let corner = |k: usize, lane: usize| [0, 1, 2].map(|axis| corners[k][axis][lane]);
    let triangle = |lane: usize| TriangleOf([0, 1, 2].map(|k| corner(k, lane)));
    let flat = lanes_of(lanes).filter(|&lane| !has_area(&triangle(lane)));
    flat.fold(0, |flat, lane| flat | 1 << lane)
}
