//! The builder: triangles in, wide nodes and blocks of triangles out.
//!
//! ```text
//! triangles ── refs ──> boxes ── binary ──> two-way tree ── wide ──> nodes of 8, blocks of 8
//! ```
//!
//! 1. [`refs`]: the box of each triangle, as one row of lanes ([`sides`]); those that are never hit are
//!    left out.
//! 2. [`binary`]: a two-way tree down to blocks of triangles by the surface-area heuristic: [`split`]
//!    puts boxes in a row, and [`sweep`] finds the cheapest cut of it. On the way back up, [`plan`]
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
mod plan;
mod refs;
mod sides;
mod split;
mod sweep;
#[cfg(test)]
mod tests;
mod wide;

#[cfg(test)]
use crate::bounds::Bounds;
#[cfg(test)]
use crate::node::EMPTY;
use crate::node::{LEAF, Node};
use intertri::Triangle;
use intertri::lanes::Level;
use std::fmt;

/// Triangles in a block.
pub(crate) const BLOCK: usize = 8;

/// No path from the root passes more nodes than this, whatever the triangles.
pub(crate) const MAX_DEPTH: usize = 64;

/// The hierarchy over a slice of triangles; it keeps their indices, not the triangles.
#[derive(Debug)]
pub(crate) struct Tree {
    /// The root is the first. The node children of a node lie side by side.
    pub nodes: Vec<Node>,
    /// Triangle indices, ascending; [`crate::node::NONE`] fills up behind them.
    pub blocks: Vec<[u32; BLOCK]>,
    /// Nodes on the longest path from the root, at least 1 and at most [`MAX_DEPTH`].
    pub depth: usize,
    /// The triangles that may be hit outside of any box, ascending.
    pub unbounded: Vec<u32>,
}

/// Why there is no hierarchy.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum BuildError {
    /// Triangles are numbered with 31 bits.
    TooManyTriangles {
        /// How many there were.
        count: usize,
    },
}

impl fmt::Display for BuildError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self::TooManyTriangles { count } = self;
        write!(
            f,
            "{count} triangles are too many for one hierarchy: split them into parts of at most 2147483647"
        )
    }
}

impl std::error::Error for BuildError {}

/// Builds the hierarchy.
#[cfg(test)]
pub(crate) fn build(triangles: &[Triangle], level: Level) -> Result<Tree, BuildError> {
    build_at(triangles, level, &|_, _| ())
}

/// Builds the hierarchy and tells from time to time how many triangles are done, of how many.
/// The calls come from any thread and may overtake each other.
pub(crate) fn build_with_progress(
    triangles: &[Triangle],
    progress: &(dyn Fn(usize, usize) + Sync),
) -> Result<Tree, BuildError> {
    build_at(triangles, Level::best(), progress)
}

fn build_at(
    triangles: &[Triangle],
    level: Level,
    progress: &(dyn Fn(usize, usize) + Sync),
) -> Result<Tree, BuildError> {
    if triangles.len() >= LEAF as usize {
        return Err(BuildError::TooManyTriangles { count: triangles.len() });
    }
    let (refs, unbounded) = refs::collect(triangles);
    if refs.is_empty() {
        return Ok(Tree { nodes: vec![Node::NO_CHILDREN], blocks: vec![], depth: 1, unbounded });
    }
    let binary = binary::build(refs, level, progress);
    Ok(Tree { unbounded, ..wide::write(&binary) })
}

#[cfg(test)]
impl Tree {
    /// The surface-area cost: what a random line through the root's box is expected to pay, in
    /// units of one node's visit.
    pub(crate) fn cost(&self) -> f64 {
        let mut root = Bounds::EMPTY;
        let children =
            |node: &Node| (0..8).filter(|&i| node.children()[i] != EMPTY).collect::<Vec<_>>();
        for i in children(&self.nodes[0]) {
            root.join(&self.nodes[0].bounds(i));
        }
        let scale = root.scale();
        let mut sum = root.half_area(scale) as f64 * plan::NODE as f64;
        for node in &self.nodes {
            for i in children(node) {
                let price = if node.children()[i] & LEAF == 0 { plan::NODE } else { plan::LEAF };
                sum += node.bounds(i).half_area(scale) as f64 * price as f64;
            }
        }
        sum / root.half_area(scale) as f64
    }
}

/// What a function gives for 0 to `count`, on all threads where there are threads.
#[cfg(feature = "parallel")]
pub(crate) fn each<T: Send>(count: usize, of: impl Fn(usize) -> T + Sync + Send) -> Vec<T> {
    use rayon::prelude::*;
    (0..count).into_par_iter().with_min_len(1 << 9).map(of).collect()
}

#[cfg(not(feature = "parallel"))]
pub(crate) fn each<T>(count: usize, of: impl Fn(usize) -> T) -> Vec<T> {
    (0..count).map(of).collect()
}

/// Runs both, side by side where there are threads.
#[cfg(feature = "parallel")]
fn join<A: Send, B: Send>(a: impl FnOnce() -> A + Send, b: impl FnOnce() -> B + Send) -> (A, B) {
    rayon::join(a, b)
}

#[cfg(not(feature = "parallel"))]
fn join<A, B>(a: impl FnOnce() -> A, b: impl FnOnce() -> B) -> (A, B) {
    (a(), b())
}
