//! Traverses the boxes of a mesh in world space. Rays use this traversal for placements without a
//! useful inverse, such as those that flatten the mesh.

use intertri::Ray64;

use super::leaves::VisitLeaves;
use super::matrix::{Matrix, world_box};
use super::mesh::Extent;
use crate::tree::{EMPTY, LEAF, Tree};
use crate::walk::single::Visit;
use intertri::simd::Simd;

/// A bound on the relative error of the t at which a ray crosses a plane.
const SHARE: f64 = 4.0 * f64::EPSILON;

/// A traversal of a mesh's tree in world space.
pub(super) struct WorldWalk<'a> {
    pub(super) tree: &'a Tree,
    pub(super) extent: &'a Extent,
    pub(super) matrix: &'a Matrix,
    pub(super) sizes: [f64; 3],
    pub(super) ray: &'a Ray64,
}

impl WorldWalk<'_> {
    /// Visits the leaves that the ray may reach, nearest children first.
    #[inline(always)]
    pub(super) fn run<S: Simd>(&self, leaves: &mut VisitLeaves<'_, S>) {
        // Triangles that are too thin for f32 boxes have a separate root.
        let mut stack = vec![(0.0, 0), (0.0, self.tree.thin_root)];
        while let Some((near, child)) = stack.pop() {
            if child == EMPTY || near > leaves.collect.far() {
                continue;
            }
            if child & LEAF != 0 {
                if leaves.visit((child ^ LEAF) as usize).is_none() {
                    return;
                }
                continue;
            }
            let node = &self.tree.nodes[child as usize];
            let start = stack.len();
            for (slot, &child) in node.children().iter().enumerate() {
                if child == EMPTY {
                    continue;
                }
                let bounds = self.extent.child_box(node, slot);
                let bounds = world_box(self.matrix, bounds, &self.sizes);
                if let Some(near) = first_t(self.ray, &bounds, leaves.collect.far()) {
                    stack.push((near, child));
                }
            }
            nearest_last(&mut stack[start..]);
        }
    }
}

/// Sorts children so that the nearest is on top of a stack.
pub(super) fn nearest_last(children: &mut [(f64, u32)]) {
    children.sort_unstable_by(|(a, _), (b, _)| b.total_cmp(a));
}

/// Returns a lower bound on the t at which the ray enters a box, or `None` if it certainly does not
/// enter the box before `far`.
fn first_t(ray: &Ray64, [lo, hi]: &[[f64; 3]; 2], far: f64) -> Option<f64> {
    let (mut first, mut last) = (ray.t_min.max(0.0), far);
    for k in 0..3 {
        let (o, d) = (ray.origin[k], ray.dir[k]);
        if d == 0.0 {
            // The comparisons are false for NaN, so a NaN origin or side counts as inside.
            if o < lo[k] || o > hi[k] {
                return None;
            }
            continue;
        }
        // Order the two sides so that the ray reaches `from` first.
        let (from, to) = if d > 0.0 { (lo[k], hi[k]) } else { (hi[k], lo[k]) };
        let (from, to) = ((from - o) / d, (to - o) / d);
        let (from, to) = (from - SHARE * from.abs(), to + SHARE * to.abs());
        // An infinite value provides no bound. The smallest normal number, subtracted or added,
        // covers underflow.
        if from < f64::INFINITY {
            first = first.max(from - f64::MIN_POSITIVE);
        }
        if to > f64::NEG_INFINITY {
            last = last.min(to + f64::MIN_POSITIVE);
        }
    }
    (first <= last).then_some(first)
}
