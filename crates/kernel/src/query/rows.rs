//! Rows of triangles: one triangle per lane of a register.

use bytemuck::Zeroable;

use super::blocks::Blocks;
use crate::filter::Triangles;
use crate::simd::{Lanes, Simd, Vec3};
use crate::{LeafSlot, Triangle};

/// Triangles that can be loaded in rows.
#[derive(Clone, Copy)]
pub(super) enum Rows<'a> {
    Slice(&'a [Triangle]),
    Blocks(&'a Blocks),
}

impl Rows<'_> {
    /// Returns the number of triangles.
    #[inline(always)]
    pub(super) fn len(self) -> usize {
        match self {
            Self::Slice(triangles) => triangles.len(),
            Self::Blocks(blocks) => blocks.len(),
        }
    }

    /// Returns the triangle in a slot.
    #[inline(always)]
    pub(super) fn triangle(self, LeafSlot(index): LeafSlot) -> Triangle {
        match self {
            Self::Slice(triangles) => triangles[index as usize],
            Self::Blocks(blocks) => blocks.triangle(index as usize),
        }
    }

    /// Loads the row that begins with a given triangle. Lanes beyond the last triangle contain
    /// arbitrary values.
    #[inline(always)]
    pub(super) fn row<S: Simd>(self, first: usize) -> Triangles<S::F32s> {
        match self {
            Self::Slice(triangles) => Triangles::of_corners(transposed::<S>(&triangles[first..])),
            Self::Blocks(blocks) => {
                let (corners, longest_edges) = blocks.row::<S::F32s>(first);
                Triangles::new(corners, longest_edges)
            }
        }
    }
}

/// Loads the corners of the first triangles in a slice into lanes.
#[inline(always)]
fn transposed<S: Simd>(triangles: &[Triangle]) -> [Vec3<S::F32s>; 3] {
    // The transposition reads whole rows, so a shorter last row is copied to a padded buffer.
    let mut padded = None;
    let row = match triangles.get(..S::F32s::N) {
        Some(row) => row,
        None => &padded.insert(padded_row(triangles))[..S::F32s::N],
    };
    // Each transposition loads four values per triangle. Three overlapping groups of four cover a
    // triangle's nine values.
    let four = |lane: usize, from: usize| {
        row[lane].0.as_flattened()[from..].first_chunk().expect("a triangle has nine coordinates")
    };
    let [x1, y1, z1, _] = S::register_columns(|lane| four(lane, 0));
    let [x2, y2, z2, _] = S::register_columns(|lane| four(lane, 3));
    let [_, x3, y3, z3] = S::register_columns(|lane| four(lane, 5));
    [Vec3 { x: x1, y: y1, z: z1 }, Vec3 { x: x2, y: y2, z: z2 }, Vec3 { x: x3, y: y3, z: z3 }]
}

/// Pads the last row, which has fewer triangles than lanes.
#[cold]
#[inline(never)]
fn padded_row(triangles: &[Triangle]) -> [Triangle; 16] {
    let mut row = [Triangle::zeroed(); 16];
    row[..triangles.len()].copy_from_slice(triangles);
    row
}
