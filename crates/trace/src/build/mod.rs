//! The builder, which takes triangles and returns wide nodes and blocks of triangles.
//!
//! ```text
//! triangles ── prim_refs ──> boxes ── binary ──> two-way tree ── reinsert, wide ──> nodes of 8, blocks of 8
//! ```
//!
//! 1. [`prim_refs`] computes the box of each triangle, as one row of lanes ([`simd_aabb`]).
//!    Triangles that are not finite are skipped.
//! 2. [`binary`] builds a two-way tree down to blocks of triangles with the surface-area heuristic:
//!    [`split`] sorts boxes into a row of bins, and [`sweep`] finds the cheapest cut. On the way
//!    back up, [`collapse`] uses dynamic programming to find the cheapest way to cut the tree into
//!    eight-way nodes and blocks of eight triangles.
//! 3. [`reinsert`] moves parts of that tree if large triangles make this worthwhile.
//! 4. [`wide`] writes the nodes and blocks of the plan in the order in which rays visit them.
//!
//! The result depends only on the triangles, never on the number of threads or the SIMD width. At
//! its peak, the builder uses about 64 bytes per triangle in addition to its input and the tree.
//! The tree itself takes 14 to 30 bytes per triangle.

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

use crate::morton::along_curve;
use crate::tree::{
    Aabb, BLOCK, EMPTY, Geometries, HitBounds, LEAF, Leaf, MOST_LEAVES, NONE, Node, Tree,
};
use crate::util::memory::{NoMemory, room};
use crate::util::threads;
use layout::Layout;
pub(crate) use layout::MAX_DEPTH;
use prim_refs::{PrimRef, Prims};
pub(crate) use triangles::Triangles;

impl Tree {
    /// Builds a hierarchy, occasionally calling `progress` with the number of triangles done and
    /// the total. Calls may come from any thread, in any order.
    pub(crate) fn over(
        triangles: &(impl Triangles + ?Sized),
        progress: &(dyn Fn(usize, usize) + Sync),
    ) -> Result<Self, BuildError> {
        let count = triangles.count();
        Self::check_count(count)?;
        Self::build(triangles, progress).map_err(|NoMemory| BuildError::OutOfMemory { count })
    }

    /// Returns an error if there are too many triangles.
    pub(crate) fn check_count(count: usize) -> Result<(), BuildError> {
        if count < LEAF as usize { Ok(()) } else { Err(BuildError::TooManyTriangles { count }) }
    }

    fn build(
        triangles: &(impl Triangles + ?Sized),
        progress: &(dyn Fn(usize, usize) + Sync),
    ) -> Result<Self, NoMemory> {
        let Layout { nodes, blocks, depth, lean, thin, has_degenerate } =
            layout_at(triangles, Level::best(), progress)?;
        // Slot numbers are 32-bit, and each leaf has eight slots. Leaves below the root come first;
        // later leaves are reached through the second tree or tested against every ray.
        let boxed = blocks.len();
        if boxed + thin.len() > MOST_LEAVES {
            return Err(NoMemory);
        }
        let leaf = |i: usize| {
            let indices = blocks[i];
            Leaf { block: triangles.block(&indices), indices }
        };
        let mut tree = Self {
            leaves: threads::each(boxed, leaf)?,
            degenerate: Vec::new(),
            nodes,
            boxed,
            thin_root: EMPTY,
            reach: 0.0,
            lean,
            stack: Self::stack_for(1 + depth),
            triangles: triangles.count(),
            geometries: Geometries::one(),
            cost_as_built: None,
        };
        if has_degenerate {
            // Rays must not hit the lanes of degenerate triangles.
            let bounds = tree.fit_leaves(triangles)?;
            tree.note_degenerate(&bounds)?;
        }
        tree.add_unboxed(triangles, &thin, &[])?;
        Ok(tree)
    }

    /// Adds leaves for triangles that are not below the root, and for degenerate triangles, which
    /// no ray hits. Neighbours share leaves, which belong to the second tree.
    pub(crate) fn add_unboxed(
        &mut self,
        triangles: &(impl Triangles + ?Sized),
        some: &[u32],
        degenerate: &[u32],
    ) -> Result<(), NoMemory> {
        let (eights, mut boxes) = in_eights(triangles, some)?;
        self.leaves.try_reserve(eights.len())?;
        self.leaves.extend(eights.into_iter().map(|indices| {
            let block = triangles.block(&indices);
            Leaf { block, indices }
        }));
        if !degenerate.is_empty() {
            let (eights, more) = in_eights(triangles, degenerate)?;
            boxes.try_reserve(more.len())?;
            boxes.extend(more);
            self.degenerate.resize(self.leaves.len(), 0);
            for indices in eights {
                let (block, bounds) = triangles.moved(&indices);
                self.leaves.push(Leaf { block, indices });
                self.degenerate.push(bounds.degenerate as u8);
            }
        }
        self.add_thin_nodes(&boxes)
    }
}

/// Builds wide nodes over numbered boxes, each of which is a leaf, and returns the nodes and their
/// depth.
pub(crate) fn nodes_over(boxes: &[(Aabb, u32)]) -> Result<(Vec<Node>, usize), NoMemory> {
    if boxes.is_empty() {
        return Ok((vec![Node::NO_CHILDREN], 1));
    }
    let refs = threads::each(boxes.len(), |i| PrimRef::new(&boxes[i].0, i as u32))?;
    let mut binary = binary::build(refs, Level::best(), &|_, _| ())?;
    reinsert::reinsert(&mut binary);
    let Layout { mut nodes, blocks, depth, .. } = wide::write(&binary)?;

    // Each block becomes a node or, if it has only one box, that box.
    let inner = nodes.len();
    nodes.try_reserve(blocks.len())?;
    for i in 0..inner {
        for slot in 0..8 {
            let child = nodes[i].children()[slot];
            if child == EMPTY || child & LEAF == 0 {
                continue;
            }
            let block = &blocks[(child ^ LEAF) as usize];
            let some: Vec<_> =
                block.iter().filter(|&&i| i != NONE).map(|&i| boxes[i as usize]).collect();
            if let [(_, number)] = *some {
                nodes[i].children_mut()[slot] = LEAF | number;
                continue;
            }
            nodes[i].children_mut()[slot] = nodes.len() as u32;
            nodes.push(wide::leaf_node(&some));
        }
    }
    Ok((nodes, depth + 1))
}

/// Puts neighbouring triangles into groups of eight and returns the groups with their bounding
/// boxes.
fn in_eights(
    triangles: &(impl Triangles + ?Sized),
    some: &[u32],
) -> Result<(Vec<[u32; BLOCK]>, Vec<Aabb>), NoMemory> {
    let bounds = |&i: &u32| match triangles.hit_bounds(i as usize) {
        HitBounds::Nowhere => Aabb::EMPTY,
        HitBounds::Box { bounds, .. } | HitBounds::Thin(bounds) | HitBounds::Degenerate(bounds) => {
            bounds
        }
    };
    // Sorting along a space-filling curve brings neighbours together without building a tree.
    let mut around = Aabb::EMPTY;
    for i in some {
        around.join(&bounds(i));
    }
    let middle = |i: usize| {
        let [x, y, z, _] = bounds(&some[i]).centre(0.5);
        [x, y, z]
    };
    let order = along_curve(&around, some.len(), middle)?;
    let count = some.len().div_ceil(BLOCK);
    let (mut eights, mut boxes) = (room(count)?, room(count)?);
    for eight in order.chunks(BLOCK) {
        let (mut indices, mut all) = ([NONE; BLOCK], Aabb::EMPTY);
        for (index, &i) in indices.iter_mut().zip(eight) {
            *index = some[i as usize];
            all.join(&bounds(index));
        }
        // Indices are in ascending order in every leaf.
        indices.sort_unstable();
        eights.push(indices);
        boxes.push(all);
    }
    Ok((eights, boxes))
}

/// Lays out the nodes and leaves.
fn layout_at(
    triangles: &(impl Triangles + ?Sized),
    level: Level,
    progress: &(dyn Fn(usize, usize) + Sync),
) -> Result<Layout, NoMemory> {
    let Prims { refs, lean, thin, has_degenerate } = prim_refs::collect(triangles)?;
    if refs.is_empty() {
        return Ok(Layout { thin, ..Layout::empty() });
    }
    let mut binary = binary::build(refs, level, progress)?;
    reinsert::reinsert(&mut binary);
    Ok(Layout { lean, thin, has_degenerate, ..wide::write(&binary)? })
}
