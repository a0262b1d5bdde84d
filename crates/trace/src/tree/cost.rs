//! Computes the cost of a tree by the surface-area heuristic.

use super::hierarchy::Tree;
use super::node::{EMPTY, Node};
use crate::util::memory::NoMemory;
use crate::util::threads;

/// The number of nodes whose costs are summed sequentially, so that the result is the same for any
/// number of threads.
const BLOCK: usize = 1 << 10;

impl Tree {
    /// Returns the expected number of nodes and leaves that a random line through the root's box
    /// visits. Leaves without a box are always visited.
    pub(crate) fn cost(&self) -> Result<f64, NoMemory> {
        let mut sums = Vec::new();
        let block = |i: usize| {
            let nodes = &self.nodes[i * BLOCK..self.nodes.len().min((i + 1) * BLOCK)];
            nodes.iter().map(|node| areas(node)[0]).sum::<f64>()
        };
        threads::extend(&mut sums, self.nodes.len().div_ceil(BLOCK), 1, block)?;
        let root = areas(&self.nodes[0])[1];
        let unboxed = (self.leaves.len() - self.boxed) as f64;
        Ok(1.0 + sums.iter().sum::<f64>() / root + unboxed)
    }
}

/// Returns the sum of the half surface areas of a node's children, and half the surface area of the
/// box around all of them. The second value is never 0.
fn areas(node: &Node) -> [f64; 2] {
    let (mut lo, mut hi, mut sum) = ([f64::INFINITY; 3], [f64::NEG_INFINITY; 3], 0.0);
    let half_area = |lo: &[f64; 3], hi: &[f64; 3]| {
        let [x, y, z] = [0, 1, 2].map(|k| hi[k] - lo[k]);
        // Add a tiny area, so that a flat root does not cause a division by 0.
        x * (y + z) + y * z + 1e-300
    };
    for slot in (0..8).filter(|&slot| node.children()[slot] != EMPTY) {
        let side = |upper| [0, 1, 2].map(|axis| f64::from(node.sides(axis, upper)[slot]));
        let (child_lo, child_hi) = (side(false), side(true));
        // A refit can leave a child in which nothing can be hit. The child's box is then inverted
        // and contributes no area.
        if child_lo[0] <= child_hi[0] {
            sum += half_area(&child_lo, &child_hi);
            lo = [0, 1, 2].map(|k| lo[k].min(child_lo[k]));
            hi = [0, 1, 2].map(|k| hi[k].max(child_hi[k]));
        }
    }
    [sum, if lo[0] <= hi[0] { half_area(&lo, &hi) } else { 1.0 }]
}
