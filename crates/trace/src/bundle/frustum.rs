//! The frustum around rays that share an origin, against the eight boxes of a node.
//!
//! After Reshetov, Soupikov and Hurley, *Multi-Level Ray Tracing Algorithm* (2005): a node is culled for all
//! rays at once.
//!
//! ```text
//!            ╱│ far corner: inside of all four planes?
//!         ╱ ┌─┼──┐
//!   o  ◄────┤ │  │   near corner: before the farthest t that still counts?
//!         ╲ └────┘
//!            ╲
//! ```
//!
//! No ray is tested against any box. `docs/numerics/hierarchy.md` proves that nothing is lost.

use intertri::internal::Frame;
use intertri::simd::{Lanes, Mask};

use super::end_plane::EndPlane;
use super::plane::CullingPlane;
use crate::tree::{Margin, Node};

/// The sides stand this much further out than any ray, as slopes: 2^-18.
const MARGIN: f32 = 1.0 / (1 << 18) as f32;

/// Four planes around rays from one origin, and the axis along which they go.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Frustum {
    sides: [CullingPlane; 4],
    axis: CullingPlane,
    /// Bit k: the axis is negative along coordinate k.
    pub(crate) octant: usize,
}

impl Frustum {
    /// The frustum around a rectangle of a frame's projection, in a tree.
    pub(crate) fn new(frame: &Frame, (lo, hi): ([f32; 2], [f32; 2]), margin: &Margin) -> Self {
        let (depth, [right, up]) = (frame.depth(), frame.across());
        let side = |across: [f32; 3], slope: f32, sign: f32| {
            let slope = slope - sign * MARGIN;
            let normal = [0, 1, 2].map(|k| sign * (across[k] - slope * depth[k]));
            CullingPlane::new(normal, frame, margin)
        };
        let sides = [
            side(right, lo[0], 1.0),
            side(right, hi[0], -1.0),
            side(up, lo[1], 1.0),
            side(up, hi[1], -1.0),
        ];
        let octant = (0..3).map(|k| usize::from(depth[k] < 0.0) << k).sum();
        Self { sides, axis: CullingPlane::new(depth, frame, margin), octant }
    }

    /// Which of a node's boxes a ray may meet before the depth `far` and, where they are known, before rays end;
    /// and from which depth on.
    #[inline(always)]
    pub(crate) fn meet<F: Lanes<Scalar = f32>>(
        &self,
        node: &Node,
        far: f32,
        ends: Option<&EndPlane>,
    ) -> (u32, F) {
        let near = self.axis.of_boxes::<F>(node, true) - F::splat(self.axis.pad);
        let mut met = near.le(F::splat(far));
        if let Some(ends) = ends {
            met = met & ends.may_meet::<F>(node);
        }
        for side in &self.sides {
            met = met & side.of_boxes::<F>(node, false).ge(F::splat(-side.pad));
        }
        (met.bits(), near)
    }

    /// How deep the boxes of a node reach.
    #[inline(always)]
    pub(crate) fn far<F: Lanes<Scalar = f32>>(&self, node: &Node) -> F {
        self.axis.of_boxes::<F>(node, false)
    }
}
