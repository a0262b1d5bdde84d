//! The triangles that a hierarchy is built over: f32 triangles, or copies of f64 triangles.

use intertri::simd::{Level, Simd, WithSimd};
use intertri::{Triangle, TriangleBlock};

use crate::tree::{BLOCK, HitBounds, LaneBounds, LeafBounds, NONE, hit_bounds};
use crate::util::lane_ops::lanes_of;

/// The triangles that a hierarchy is built over.
pub(crate) trait Triangles: Sync {
    /// The number of triangles.
    fn count(&self) -> usize;
    /// The box in which a triangle can be hit.
    fn hit_bounds(&self, i: usize) -> HitBounds;
    /// The triangles of a leaf, side by side.
    fn block(&self, indices: &[u32; BLOCK]) -> TriangleBlock<8>;
    /// The triangles of a leaf after a refit, with dead lanes for those that cannot be hit in a box; and the
    /// box around all others and those without area, which keep their corners.
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
        Level::best().run(Moved { triangles: self, indices })
    }
}

/// Loads the triangles of a leaf side by side.
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

/// Loads the triangles of a leaf at their new positions, with the box around them.
struct Moved<'a> {
    triangles: &'a [Triangle],
    indices: &'a [u32; BLOCK],
}

impl WithSimd for Moved<'_> {
    type Output = (TriangleBlock<8>, LeafBounds);

    #[inline(always)]
    fn run<S: Simd>(self) -> Self::Output {
        // Corners go straight into lanes: a refit runs this for every leaf.
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

/// Fills the lanes without a triangle with one that can be hit, or with any triangle that has an area. A
/// filler without area would be loaded from a saved hierarchy as a triangle of its own.
fn fill_absent(corners: &mut [[[f32; 8]; 3]; 3], present: u32, live: u32) {
    let absent = 0xff & !present;
    if absent == 0 {
        return;
    }
    let from = lanes_of(live).next();
    for (k, rows) in corners.iter_mut().enumerate() {
        for (axis, row) in rows.iter_mut().enumerate() {
            // If no triangle is live, use corners at 1 on each axis, which span an area.
            let x = from.map_or(if k == axis { 1.0 } else { 0.0 }, |from| row[from]);
            lanes_of(absent).for_each(|lane| row[lane] = x);
        }
    }
}
