//! What a hierarchy is built over: triangles, or copies of triangles that are given in f64.

use intertri::simd::{Level, Simd, WithSimd};
use intertri::{Triangle, TriangleBlock};

use crate::tree::{BLOCK, HitBounds, NONE, hit_bounds};

/// What a hierarchy is built over.
pub(crate) trait Triangles: Sync {
    /// How many there are.
    fn count(&self) -> usize;
    /// Where one can be hit.
    fn hit_bounds(&self, i: usize) -> HitBounds;
    /// Those of a leaf side by side.
    fn block(&self, indices: &[u32; BLOCK]) -> TriangleBlock<8>;
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
}

/// The triangles of a leaf side by side.
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
