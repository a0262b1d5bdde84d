//! The triangles that a hierarchy is built over: f32 triangles, or f32 copies of f64 triangles.

use intertri::simd::{Level, Simd, WithSimd};
use intertri::{Triangle, TriangleBlock};

use crate::tree::{BLOCK, HitBounds, LaneBounds, LeafBounds, NONE, hit_bounds};
use crate::util::lane_ops::lanes_of;

/// A source of triangles for building a hierarchy.
pub(crate) trait Triangles: Sync {
    /// Returns the number of triangles.
    fn count(&self) -> usize;
    /// Returns the hit bounds of a triangle.
    fn hit_bounds(&self, i: usize) -> HitBounds;
    /// Returns the triangles of a leaf in structure-of-arrays layout.
    fn block(&self, indices: &[u32; BLOCK]) -> TriangleBlock<8>;
    /// Returns the triangles of a leaf after a refit, and their bounds. A triangle gets a dead lane
    /// if it cannot be hit, or if no box contains all of its hits. The bounds cover all other
    /// triangles, and also degenerate ones, which keep their corners in the leaf.
    fn moved(&self, indices: &[u32; BLOCK]) -> (TriangleBlock<8>, LeafBounds);
}

impl Triangles for [Triangle] {
    #[inline]
    fn count(&self) -> usize {
        self.len()
    }

    #[inline]
    fn hit_bounds(&self, i: usize) -> HitBounds {
        hit_bounds(&self[i])
    }

    #[inline]
    fn block(&self, indices: &[u32; BLOCK]) -> TriangleBlock<8> {
        Level::best().run(SideBySide { triangles: self, indices })
    }

    #[inline]
    fn moved(&self, indices: &[u32; BLOCK]) -> (TriangleBlock<8>, LeafBounds) {
        Level::best().run(PackLeaf { triangles: self, indices })
    }
}

/// Packs the triangles of a leaf into lanes.
struct SideBySide<'a> {
    triangles: &'a [Triangle],
    indices: &'a [u32; BLOCK],
}

impl WithSimd for SideBySide<'_> {
    type Output = TriangleBlock<8>;
    #[inline(always)]
    fn run<S: Simd>(self) -> TriangleBlock<8> {
        let mut corners = [Triangle([[0.0; 3]; 3]); 8];
        let mut count = 0;
        for &i in self.indices.iter().take_while(|&&i| i != NONE) {
            corners[count] = self.triangles[i as usize];
            count += 1;
        }
        TriangleBlock::new_in::<S>(&corners[..count])
    }
}

/// Packs the triangles of a leaf at their new positions and computes their bounds.
struct PackLeaf<'a> {
    triangles: &'a [Triangle],
    indices: &'a [u32; BLOCK],
}

impl WithSimd for PackLeaf<'_> {
    type Output = (TriangleBlock<8>, LeafBounds);

    #[inline(always)]
    fn run<S: Simd>(self) -> Self::Output {
        // Write corners straight into lanes, because a refit runs this for every leaf.
        let (mut corners, mut lanes) = ([[[0.0; 8]; 3]; 3], 0);
        for (lane, &index) in self.indices.iter().enumerate() {
            if index == NONE {
                break;
            }
            lanes |= 1 << lane;
            let triangle = &self.triangles[index as usize];
            for (rows, corner) in corners.iter_mut().zip(&triangle.0) {
                for (row, &x) in rows.iter_mut().zip(corner) {
                    row[lane] = x;
                }
            }
        }
        let bounds = LaneBounds { corners: &corners, lanes }.run::<S>();

        fill_absent(&mut corners, bounds.present(), bounds.boxed);
        (TriangleBlock::of_lanes_in::<S>(corners, bounds.boxed), bounds)
    }
}

/// Fills the lanes that hold no triangle with a copy of a triangle that can be hit or, if there is
/// none, with a dummy triangle. The dummy is not degenerate, because loading a saved hierarchy
/// would mistake a degenerate one for a real triangle.
fn fill_absent(corners: &mut [[[f32; 8]; 3]; 3], present: u32, live: u32) {
    let absent = 0xff & !present;
    if absent == 0 {
        return;
    }
    let from = lanes_of(live).next();
    for (k, rows) in corners.iter_mut().enumerate() {
        for (axis, row) in rows.iter_mut().enumerate() {
            // If no triangle is live, use the triangle with corners (1,0,0), (0,1,0), and (0,0,1),
            // which is not degenerate.
            let x = from.map_or(if k == axis { 1.0 } else { 0.0 }, |from| row[from]);
            lanes_of(absent).for_each(|lane| row[lane] = x);
        }
    }
}
