//! The builder: triangles in, wide nodes and blocks of triangles out.
//!
//! ```text
//! triangles ── prim_refs ──> boxes ── binary ──> two-way tree ── reinsert, wide ──> nodes of 8, blocks of 8
//! ```
//!
//! 1. [`prim_refs`]: the box of each triangle, as one row of lanes ([`simd_aabb`]); those that are not finite are
//!    left out.
//! 2. [`binary`]: a two-way tree down to blocks of triangles by the surface-area heuristic: [`split`]
//!    puts boxes in a row, and [`sweep`] finds the cheapest cut of it. On the way back up, [`collapse`]
//!    finds by dynamic programming how to cut the tree into nodes of eight and blocks of eight at the
//!    least cost.
//! 3. [`reinsert`]: where large triangles make it pay, parts of that tree are put elsewhere.
//! 4. [`wide`]: the nodes and blocks of that plan, written in the order in which rays want them.
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
mod reinsert;
mod simd_aabb;
mod split;
mod sweep;
#[cfg(test)]
mod tests;
mod triangles;
mod wide;

pub use error::BuildError;

use intertri::simd::Level;

use crate::memory::NoMemory;
use crate::threads;
use crate::tree::{Geometries, LEAF, Leaf, MOST_LEAVES, NONE, Node, Tree};
use layout::Layout;
pub(crate) use layout::MAX_DEPTH;
use prim_refs::Prims;
pub(crate) use triangles::Triangles;

impl Tree {
    /// Builds a hierarchy, telling from time to time how many triangles are done, of how many. The calls come from
    /// any thread and may overtake each other.
    pub(crate) fn over(
        triangles: &(impl Triangles + ?Sized),
        progress: &(dyn Fn(usize, usize) + Sync),
    ) -> Result<Self, BuildError> {
        let count = triangles.count();
        Self::check_count(count)?;
        Self::build(triangles, progress).map_err(|NoMemory| BuildError::OutOfMemory { count })
    }

    /// Whether so many triangles are not too many.
    pub(crate) fn check_count(count: usize) -> Result<(), BuildError> {
        if count < LEAF as usize { Ok(()) } else { Err(BuildError::TooManyTriangles { count }) }
    }

    fn build(
        triangles: &(impl Triangles + ?Sized),
        progress: &(dyn Fn(usize, usize) + Sync),
    ) -> Result<Self, NoMemory> {
        let Layout { nodes, mut blocks, depth, unbounded, has_degenerate } =
            layout_at(triangles, Level::best(), progress)?;
        let boxed = blocks.len();

        // Triangles of which no box is known follow the leaves, in blocks of their own.
        blocks.try_reserve(unbounded.len().div_ceil(8))?;
        blocks.extend(unbounded.chunks(8).map(|chunk| {
            let mut block = [NONE; 8];
            block[..chunk.len()].copy_from_slice(chunk);
            block
        }));
        // A triangle's place, eight a leaf, has 32 bits.
        if blocks.len() > MOST_LEAVES {
            return Err(NoMemory);
        }
        let leaf = |i: usize| {
            let indices = blocks[i];
            Leaf { block: triangles.block(&indices), indices }
        };
        let mut tree = Self {
            leaves: threads::each(blocks.len(), leaf)?,
            degenerate: Vec::new(),
            nodes,
            boxed,
            reach: 0.0,
            stack: Self::stack_for(depth),
            triangles: triangles.count(),
            geometries: Geometries::one(),
            cost_as_built: None,
        };
        if has_degenerate {
            // Rays must not see them.
            let bounds = tree.fit_leaves(triangles)?;
            tree.note_degenerate(&bounds)?;
        }
        tree.reach = tree.find_reach();
        Ok(tree)
    }
}

/// Lays out the nodes and leaves.
fn layout_at(
    triangles: &(impl Triangles + ?Sized),
    level: Level,
    progress: &(dyn Fn(usize, usize) + Sync),
) -> Result<Layout, NoMemory> {
    let Prims { refs, unbounded, has_degenerate } = prim_refs::collect(triangles)?;
    if refs.is_empty() {
        let nodes = vec![Node::NO_CHILDREN];
        return Ok(Layout { nodes, depth: 1, unbounded, ..Layout::default() });
    }
    let mut binary = binary::build(refs, level, progress)?;
    reinsert::reinsert(&mut binary);
    Ok(Layout { unbounded, has_degenerate, ..wide::write(&binary)? })
}
