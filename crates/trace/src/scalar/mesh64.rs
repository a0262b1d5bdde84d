//! An f64 mesh for closest-point queries. Its boxes enclose the f32 copies, while f64 lanes and
//! exact arithmetic use the original triangles.

use intertri::internal::LocalFrame;
use intertri::simd::{Lanes, Simd, Vec3};
use intertri::{LeafSlot, Triangle64};

use crate::nearest::{Mesh, QueryPoint};
use crate::save::EightTriangles;
use crate::tree::Tree;
use crate::util::lane_ops::lanes_of;

/// Coordinates with magnitudes up to this (`2^400`) do not overflow in f64 lanes.
const FAR_OUT: f64 = f64::from_bits((1023 + 400) << 52);

/// A mesh in f64, and the tree over its f32 copies.
#[derive(Clone, Copy)]
pub(super) struct Mesh64<'a> {
    pub(super) tree: &'a Tree,
    pub(super) frame: &'a LocalFrame,
    pub(super) leaves: &'a [EightTriangles],
}

impl Mesh for Mesh64<'_> {
    type Scalar = f64;

    #[inline(always)]
    fn tree(&self) -> &Tree {
        self.tree
    }

    #[inline(always)]
    fn at(&self, point: [f64; 3]) -> QueryPoint {
        let frame = self.frame;
        let (room, scale) = (frame.corner_room(), frame.scale());
        let [from, to] = frame.around_point(point);
        // Corners are reconstructed from rounded edges, so they are less accurate than the leaf's
        // box; `room` covers the difference.
        let in_leaves = [from.map(|x| (x - room).next_down()), to.map(|x| (x + room).next_up())];
        // Beyond 2^400, f64 lanes could overflow. A NaN coordinate makes the bounds computed in
        // lanes inconclusive.
        let scaled = |x: f64| if (x * scale).abs() <= FAR_OUT { x * scale } else { f64::NAN };
        QueryPoint { within: [from, to], in_leaves, point: point.map(scaled) }
    }

    #[inline(always)]
    fn scaled(&self, length: f64) -> f64 {
        length * self.frame.scale()
    }

    #[inline(always)]
    fn near_corners<F: Lanes<Scalar = f32>>(&self, leaf: usize) -> [Vec3<F>; 3] {
        // A copy stores the first corner, the edge from the second corner to the first, and the
        // edge from the first corner to the third.
        let [a, minus_h4, h5] = self.tree.leaves[leaf].block.corners();
        let a = Vec3::<F>::load(a);
        [a, a - Vec3::load(minus_h4), a + Vec3::load(h5)]
    }

    #[inline(always)]
    fn corners<S: Simd>(&self, leaf: usize, lanes: u32) -> [Vec3<S::F64x8>; 3] {
        let (triangles, scale) = (&self.leaves[leaf], self.frame.scale());
        let mut corners = [[[0.0; 8]; 3]; 3];
        for lane in lanes_of(lanes) {
            for (rows, corner) in corners.iter_mut().zip(&triangles[lane].0) {
                for (row, x) in rows.iter_mut().zip(corner) {
                    // The scale is a power of two, so the products are exact.
                    row[lane] = x * scale;
                }
            }
        }
        [Vec3::load(&corners[0]), Vec3::load(&corners[1]), Vec3::load(&corners[2])]
    }

    #[inline(always)]
    fn triangle(&self, slot: LeafSlot) -> Triangle64 {
        self.leaves.as_flattened()[slot.0 as usize]
    }
}
