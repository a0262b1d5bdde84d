//! The tree of instances. Each node has up to eight children, which are other nodes or instances.

use intertri::TriangleOf;
use intertri::internal::LocalFrame;
use intertri::simd::{Lanes, Vec3};

use super::matrix::TreeRay;
use crate::build::nodes_over;
use crate::tree::{Aabb, Node, Tree};
use crate::util::crowd::crowd;
use crate::util::memory::{NoMemory, room};

/// A tree over the boxes of instances, in f32 relative to the centre of the scene.
#[derive(Debug)]
pub(super) struct Top {
    pub(super) nodes: Vec<Node>,
    pub(super) stack: usize,
    frame: LocalFrame,
    /// The largest magnitude of a box coordinate.
    pub(super) reach: f32,
    /// The number of instances below the nodes.
    pub(super) boxed: usize,
    /// Instances with infinite boxes.
    pub(super) everywhere: Vec<u32>,
}

/// An instance and its bounding box.
#[derive(Clone, Copy, Debug)]
pub(super) struct InstanceBox {
    pub(super) instance: u32,
    pub(super) bounds: [[f64; 3]; 2],
}

impl Top {
    /// Builds the tree over instances.
    pub(super) fn over(boxes: &[InstanceBox]) -> Result<Self, NoMemory> {
        let (mut around, mut everywhere) =
            ([[f64::INFINITY; 3], [f64::NEG_INFINITY; 3]], Vec::new());
        let mut finite = room(boxes.len())?;
        for one in boxes {
            let [lo, hi] = one.bounds;
            // NaN or an infinity on any side makes the sum NaN.
            if lo.iter().chain(&hi).map(|x| x * 0.0).sum::<f64>() != 0.0 {
                everywhere.try_reserve(1)?;
                everywhere.push(one.instance);
                continue;
            }
            for k in 0..3 {
                around[0][k] = around[0][k].min(lo[k]);
                around[1][k] = around[1][k].max(hi[k]);
            }
            finite.push(one);
        }
        let middle =
            |one: &&InstanceBox| [0, 1, 2].map(|k| 0.5 * one.bounds[0][k] + 0.5 * one.bounds[1][k]);
        // f32 is most precise near 0, so centre the frame where most instances are. Otherwise, one
        // distant instance would make all boxes imprecise.
        let frame = LocalFrame::around(around, crowd(finite.iter().map(middle)));

        let (mut reach, mut scaled) = (0.0_f32, room(finite.len())?);
        for one in &finite {
            let [lo, hi] = one.bounds;
            // The frame rounds the boxes of triangles outward, so pass a degenerate triangle that
            // spans two opposite corners.
            let Some([lo, hi]) = frame.bounds(&TriangleOf([lo, hi, lo])) else {
                everywhere.try_reserve(1)?;
                everywhere.push(one.instance);
                continue;
            };
            reach = lo.iter().chain(&hi).fold(reach, |reach, x| reach.max(x.abs()));
            let [lo, hi] = [lo, hi].map(|[x, y, z]| [x, y, z, 0.0]);
            scaled.push((Aabb { lo, hi }, one.instance));
        }
        let (nodes, depth) = nodes_over(&scaled)?;
        Ok(Self {
            nodes,
            stack: Tree::stack_for(1 + depth),
            frame,
            reach,
            boxed: scaled.len(),
            everywhere,
        })
    }

    /// Returns a world-space box that contains the box of a node's child.
    #[inline(always)]
    pub(super) fn child_box(&self, node: &Node, slot: usize) -> [[f64; 3]; 2] {
        let ((centre, _), scale) = (self.frame.centre_and_exponent(), self.frame.scale());
        [false, true].map(|upper| {
            [0, 1, 2].map(|axis| {
                let side = f64::from(node.sides(axis, upper)[slot]) / scale;
                // The margin exceeds the rounding error of the sum.
                let room = f64::EPSILON * (side.abs() + centre[axis].abs()) + f64::MIN_POSITIVE;
                side + centre[axis] + if upper { room } else { -room }
            })
        })
    }

    /// Transforms rays to the tree's units.
    #[inline(always)]
    pub(super) fn tree_ray<D: Lanes<Scalar = f64>>(
        &self,
        [origin, dir]: [Vec3<D>; 2],
    ) -> TreeRay<D> {
        let ((centre, _), scale) = (self.frame.centre_and_exponent(), D::splat(self.frame.scale()));
        // The boxes are rounded outward and contain all hits of their instances, so no further
        // margin is needed.
        let origin = (origin - Vec3::splat(centre)) * scale;
        TreeRay { origin, dir: dir * scale, room: D::splat(0.0) }
    }
}
