//! Defines the trait `Mesh`, through which the closest-point search accesses a mesh, and implements
//! it for f32.

use intertri::simd::{Lanes, Simd, Vec3};
use intertri::{LeafSlot, Scalar, Triangle, TriangleOf};

use crate::tree::Tree;

/// A mesh in f32 or f64, and the tree over it or over f32 copies of it. The search works in the
/// tree's units, which differ from the mesh's by a power of two.
pub(crate) trait Mesh: Copy {
    /// The scalar type of the coordinates.
    type Scalar: Scalar;

    /// Returns the tree over the mesh.
    fn tree(&self) -> &Tree;

    /// Converts a point to the tree's units.
    fn at(&self, point: [Self::Scalar; 3]) -> QueryPoint;

    /// Converts a length to the tree's units.
    fn scaled(&self, length: f64) -> f64;

    /// Returns the approximate corners of a leaf's triangles in the tree's units.
    fn near_corners<F: Lanes<Scalar = f32>>(&self, leaf: usize) -> [Vec3<F>; 3];

    /// Returns, in the tree's units, the corners of the leaf's triangles in the given lanes. They
    /// are exact except for underflow. Other lanes are arbitrary.
    fn corners<S: Simd>(&self, leaf: usize, lanes: u32) -> [Vec3<S::F64x8>; 3];

    /// Returns the triangle in a leaf slot.
    fn triangle(&self, slot: LeafSlot) -> TriangleOf<Self::Scalar>;
}

/// A query point in the tree's units.
#[derive(Clone, Copy, Debug)]
pub(crate) struct QueryPoint {
    /// Two points that certainly enclose the query point between them.
    pub(crate) within: [[f32; 3]; 2],
    /// [`Self::within`], widened by the error of [`Mesh::near_corners`].
    pub(crate) in_leaves: [[f32; 3]; 2],
    /// The query point, exact except for underflow.
    pub(crate) point: [f64; 3],
}

/// An f32 mesh, whose tree is built directly over its triangles.
#[derive(Clone, Copy)]
pub(crate) struct InF32<'a>(pub(crate) &'a Tree);

impl Mesh for InF32<'_> {
    type Scalar = f32;

    #[inline(always)]
    fn tree(&self) -> &Tree {
        self.0
    }

    #[inline(always)]
    fn at(&self, point: [f32; 3]) -> QueryPoint {
        QueryPoint { within: [point; 2], in_leaves: [point; 2], point: point.map(f64::from) }
    }

    #[inline(always)]
    fn scaled(&self, length: f64) -> f64 {
        length
    }

    #[inline(always)]
    fn near_corners<F: Lanes<Scalar = f32>>(&self, leaf: usize) -> [Vec3<F>; 3] {
        let [a, b, c] = self.0.leaves[leaf].block.corners();
        [Vec3::load(a), Vec3::load(b), Vec3::load(c)]
    }

    #[inline(always)]
    fn corners<S: Simd>(&self, leaf: usize, _: u32) -> [Vec3<S::F64x8>; 3] {
        let [a, b, c] = self.0.leaves[leaf].block.corners();
        [Vec3::load_f32(a), Vec3::load_f32(b), Vec3::load_f32(c)]
    }

    #[inline(always)]
    fn triangle(&self, slot: LeafSlot) -> Triangle {
        self.0.triangle_in(slot)
    }
}
