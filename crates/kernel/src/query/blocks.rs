//! Triangles that are loaded into lanes once, for many rays.

use alloc::vec::Vec;

use crate::Triangle;
use crate::packet::TriangleBlock;
use crate::simd::{Lanes, Vec3};

/// Triangles prepared for many rays.
///
/// The queries of [`Mode`](crate::Mode) over plain slices load the triangles into lanes for each
/// ray. `Blocks` loads them once and keeps a copy. Its results are the same as for the slice. For
/// more than a few hundred triangles, a BVH is faster, such as `Bvh` in the `intertri-trace` crate.
///
/// ```
/// use intertri::{Blocks, Mode, Ray, Triangle};
/// let at = |z| Triangle::new([0.0, 0.0, z], [1.0, 0.0, z], [0.0, 1.0, z]);
/// let walls = [at(5.0), at(-1.0), at(3.0)];
/// let blocks = Blocks::new(&walls);
///
/// let (mode, ray) = (Mode::exact(), Ray::new([0.25, 0.25, 0.0], [0.0, 0.0, 1.0]));
/// let hit = blocks.closest(mode, &ray).unwrap();
/// assert_eq!((hit.triangle, hit.t), (2, 3.0));
/// assert_eq!(Some(hit), mode.closest(&walls, &ray));
/// assert!(blocks.any(mode, &ray));
/// assert_eq!(blocks.all(mode, &ray), mode.all(&walls, &ray));
/// ```
#[derive(Clone, Debug, Default)]
pub struct Blocks {
    blocks: Vec<Aligned>,
    len: usize,
}

/// A block, aligned so that each row of sixteen values fills one cache line.
#[derive(Clone, Copy, Debug)]
#[repr(align(64))]
struct Aligned(TriangleBlock<16>);

impl Blocks {
    /// Prepares the triangles in a slice.
    pub fn new(triangles: &[Triangle]) -> Self {
        let block = |triangles| Aligned(TriangleBlock::new(triangles));
        Self { blocks: triangles.chunks(16).map(block).collect(), len: triangles.len() }
    }

    /// Returns the number of triangles.
    ///
    /// ```
    /// use intertri::{Blocks, Triangle};
    /// let triangle = Triangle::new([0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]);
    /// let blocks = Blocks::new(&[triangle; 20]);
    /// assert_eq!((blocks.len(), blocks.is_empty(), blocks.triangle(19)), (20, false, triangle));
    /// ```
    pub fn len(&self) -> usize {
        self.len
    }

    /// Returns whether there are no triangles.
    pub fn is_empty(&self) -> bool {
        self.len == 0
    }

    /// Returns the triangle with the given index.
    ///
    /// # Panics
    /// Panics if the index is out of bounds.
    pub fn triangle(&self, index: usize) -> Triangle {
        assert!(index < self.len, "index out of bounds: there are {} triangles", self.len);
        self.blocks[index / 16].0.triangle(index % 16)
    }

    /// Loads a row: one triangle per lane, with upper bounds on the longest edges.
    #[inline(always)]
    pub(super) fn row<F: Lanes<Scalar = f32>>(&self, first: usize) -> ([Vec3<F>; 3], F) {
        // Sixteen is a multiple of the width at every level, so a row never spans two blocks.
        let (Aligned(block), lane) = (&self.blocks[first / 16], first % 16);
        let [c1, c2, c3] = block.corners();
        let longest_edges = F::load(&block.longest_edges()[lane..]);
        ([lanes_from(c1, lane), lanes_from(c2, lane), lanes_from(c3, lane)], longest_edges)
    }
}

/// Loads three rows, starting at `lane`.
#[inline(always)]
fn lanes_from<F: Lanes<Scalar = f32>>([x, y, z]: &[[f32; 16]; 3], lane: usize) -> Vec3<F> {
    Vec3 { x: F::load(&x[lane..]), y: F::load(&y[lane..]), z: F::load(&z[lane..]) }
}
