//! The builder: triangles in, wide nodes and blocks of triangles out.
//!
//! ```text
//! triangles ── prim_refs ──> boxes ── binary ──> two-way tree ── wide ──> nodes of 8, blocks of 8
//! ```
//!
//! 1. [`prim_refs`]: the box of each triangle, as one row of lanes ([`simd_aabb`]); those that are never hit are
//!    left out.
//! 2. [`binary`]: a two-way tree down to blocks of triangles by the surface-area heuristic: [`split`]
//!    puts boxes in a row, and [`sweep`] finds the cheapest cut of it. On the way back up, [`collapse`]
//!    finds by dynamic programming how to cut the tree into nodes of eight and blocks of eight at the
//!    least cost.
//! 3. [`wide`]: the nodes and blocks of that plan, written in the order in which rays want them.
//!
//! The result depends on the triangles alone, never on the number of threads or the CPU's lanes. At
//! its peak the builder holds about 64 bytes a triangle besides its input and the tree, which itself
//! takes 14 to 30.

mod binary;
#[cfg(test)]
mod check;
mod collapse;
mod error;
mod layout;
mod prim_refs;
mod simd_aabb;
mod split;
mod sweep;
#[cfg(test)]
mod tests;
mod wide;

pub use error::BuildError;

use intertri::simd::{Level, Simd, WithSimd};
use intertri::{Triangle, TriangleBlock};

use crate::memory::{NoMemory, room};
use crate::threads;
use crate::tree::{BLOCK, Bvh, Geometries, LEAF, Leaf, NONE, Node};
use layout::Layout;
pub(crate) use layout::MAX_DEPTH;

impl Bvh {
    /// Builds a hierarchy over triangles, which keep their indices.
    ///
    /// # Errors
    /// If there are 2^31 triangles or more, or too little memory.
    pub fn new(triangles: &[Triangle]) -> Result<Self, BuildError> {
        Self::with_progress(triangles, &|_, _| ())
    }

    /// A hierarchy over several meshes, each a geometry by its place among them: hits tell it beside the
    /// triangle's number within it. Of equal t, the lowest geometry is closer, then the lowest triangle.
    ///
    /// # Errors
    /// If there are 2^31 triangles or more, or too little memory.
    ///
    /// ```
    /// use intertri_trace::Bvh;
    /// use intertri_trace::intertri::{Exact, Ray, Triangle};
    /// let at = |z| Triangle::new([0.0, 0.0, z], [1.0, 0.0, z], [0.0, 1.0, z]);
    /// let bvh = Bvh::of_meshes(&[&[at(7.0)], &[], &[at(5.0), at(3.0)]])?;
    /// let ray = Ray::new([0.2, 0.2, 0.0], [0.0, 0.0, 1.0]);
    /// let hits = bvh.all(&Exact::default(), &ray);
    /// assert!(hits.iter().map(|hit| (hit.geometry, hit.triangle)).eq([(2, 1), (2, 0), (0, 0)]));
    /// # Ok::<(), intertri_trace::BuildError>(())
    /// ```
    pub fn of_meshes(meshes: &[&[Triangle]]) -> Result<Self, BuildError> {
        let count = meshes.iter().map(|mesh| mesh.len()).sum();
        if count >= LEAF as usize {
            return Err(BuildError::TooManyTriangles { count });
        }
        let out_of_memory = |NoMemory| BuildError::OutOfMemory { count };
        let mut all = room(count).map_err(out_of_memory)?;
        for mesh in meshes {
            all.extend_from_slice(mesh);
        }
        let counts = meshes.iter().map(|mesh| mesh.len());
        let geometries = Geometries::of(counts).map_err(out_of_memory)?;
        Ok(Self { geometries, ..Self::new(&all)? })
    }

    /// A hierarchy over triangles that share vertices: three indices a triangle.
    ///
    /// # Errors
    /// If there are 2^31 triangles or more, or too little memory.
    ///
    /// # Panics
    /// If an index is beyond the positions.
    pub fn indexed(positions: &[[f32; 3]], triangles: &[[u32; 3]]) -> Result<Self, BuildError> {
        let corners = |i: usize| Triangle(triangles[i].map(|i| positions[i as usize]));
        let corners = threads::each(triangles.len(), corners);
        Self::new(&corners.map_err(|NoMemory| BuildError::OutOfMemory { count: triangles.len() })?)
    }

    /// [`Bvh::new`], telling from time to time how many triangles are done, of how many. The calls
    /// come from any thread and may overtake each other.
    ///
    /// # Errors
    /// If there are 2^31 triangles or more, or too little memory.
    pub fn with_progress(
        triangles: &[Triangle],
        progress: &(dyn Fn(usize, usize) + Sync),
    ) -> Result<Self, BuildError> {
        let count = triangles.len();
        if count >= LEAF as usize {
            return Err(BuildError::TooManyTriangles { count });
        }
        Self::build(triangles, progress).map_err(|NoMemory| BuildError::OutOfMemory { count })
    }

    fn build(
        triangles: &[Triangle],
        progress: &(dyn Fn(usize, usize) + Sync),
    ) -> Result<Self, NoMemory> {
        let Layout { nodes, mut blocks, depth, unbounded } =
            layout_at(triangles, Level::best(), progress)?;
        let boxed = blocks.len();

        // Triangles of which no box is known follow the leaves, in blocks of their own.
        blocks.try_reserve(unbounded.len().div_ceil(8))?;
        blocks.extend(unbounded.chunks(8).map(|chunk| {
            let mut block = [NONE; 8];
            block[..chunk.len()].copy_from_slice(chunk);
            block
        }));
        let level = Level::best();
        let leaf = |i: usize| {
            let indices = blocks[i];
            Leaf { block: level.run(SideBySide { triangles, indices: &indices }), indices }
        };
        let mut bvh = Self {
            leaves: threads::each(blocks.len(), leaf)?,
            nodes,
            boxed,
            reach: 0.0,
            stack: Self::stack_for(depth),
            triangles: triangles.len(),
            geometries: Geometries::one(),
            cost_as_built: None,
        };
        bvh.reach = bvh.find_reach();
        Ok(bvh)
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

/// Lays out the nodes and leaves.
fn layout_at(
    triangles: &[Triangle],
    level: Level,
    progress: &(dyn Fn(usize, usize) + Sync),
) -> Result<Layout, NoMemory> {
    let (refs, unbounded) = prim_refs::collect(triangles)?;
    if refs.is_empty() {
        return Ok(Layout { nodes: vec![Node::NO_CHILDREN], blocks: vec![], depth: 1, unbounded });
    }
    let binary = binary::build(refs, level, progress)?;
    Ok(Layout { unbounded, ..wide::write(&binary)? })
}
