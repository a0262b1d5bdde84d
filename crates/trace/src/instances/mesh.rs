//! The meshes of a scene, each of which several instances can share.

use std::sync::Arc;

use intertri::LeafSlot;
use intertri::simd::{Simd, Vec3};

use crate::bvh::Bvh;
use crate::scalar::{Backend, BvhScalar};
use crate::tree::{Node, Tree};
use crate::util::lane_ops::lanes_of;

/// A mesh that instances can share: a [`Bvh`] in f32 or f64. An `Arc` of either type converts into
/// a `SceneMesh`.
#[derive(Clone, Debug)]
pub enum SceneMesh {
    /// A mesh in f32.
    F32(Arc<Bvh<f32>>),
    /// A mesh in f64.
    F64(Arc<Bvh<f64>>),
}

impl From<Arc<Bvh<f32>>> for SceneMesh {
    fn from(mesh: Arc<Bvh<f32>>) -> Self {
        Self::F32(mesh)
    }
}

impl From<Arc<Bvh<f64>>> for SceneMesh {
    fn from(mesh: Arc<Bvh<f64>>) -> Self {
        Self::F64(mesh)
    }
}

impl SceneMesh {
    /// Returns the tree over the mesh.
    #[inline]
    pub(super) fn tree(&self) -> &Tree {
        match self {
            Self::F32(mesh) => &mesh.tree,
            Self::F64(mesh) => &mesh.tree,
        }
    }

    /// Returns the corners of a leaf's triangles.
    #[inline(always)]
    pub(super) fn leaf_corners<S: Simd>(&self, leaf: usize) -> [Vec3<S::F64x8>; 3] {
        match self {
            Self::F32(mesh) => f32::leaf_corners::<S>(&mesh.tree, &mesh.originals, leaf),
            Self::F64(mesh) => f64::leaf_corners::<S>(&mesh.tree, &mesh.originals, leaf),
        }
    }

    /// Returns the corners of the triangle in a slot.
    pub(super) fn corners_in(&self, slot: LeafSlot) -> [[f64; 3]; 3] {
        match self {
            Self::F32(mesh) => mesh.triangle_in(slot).0.map(|corner| corner.map(Into::into)),
            Self::F64(mesh) => mesh.triangle_in(slot).0,
        }
    }

    /// Returns the mesh's memory address, which identifies it.
    pub(super) fn address(&self) -> usize {
        match self {
            Self::F32(mesh) => Arc::as_ptr(mesh).addr(),
            Self::F64(mesh) => Arc::as_ptr(mesh).addr(),
        }
    }

    /// Computes the properties of the mesh that a scene needs.
    pub(super) fn extent(&self) -> Extent {
        match self {
            Self::F32(mesh) => Extent::of(mesh),
            Self::F64(mesh) => Extent::of(mesh),
        }
    }
}

/// The bounds of a mesh, and the units of its tree.
#[derive(Clone, Copy, Debug)]
pub(super) struct Extent {
    /// The box around all finite triangles.
    pub(super) bounds: [[f64; 3]; 2],
    /// The tree stores `(x - centre) * scale` for a coordinate x.
    pub(super) centre: [f64; 3],
    pub(super) scale: f64,
    /// The smallest magnitude of any nonzero coordinate.
    pub(super) least: f64,
}

impl Extent {
    fn of<S: BvhScalar>(mesh: &Bvh<S>) -> Self {
        let tree = &mesh.tree;
        let (centre, scale) = S::frame(&mesh.originals);
        let mut least = f64::INFINITY;
        for i in 0..tree.leaves.len() {
            for lane in lanes_of(tree.present(i)) {
                let triangle = mesh.triangle_in(LeafSlot((8 * i + lane) as u32));
                for &x in triangle.0.as_flattened() {
                    // Test the bits, because the CPU may be set to treat subnormal numbers as 0.
                    if x.rank() != 0 {
                        least = least.min(Into::<f64>::into(x).abs());
                    }
                }
            }
        }
        let mut extent =
            Self { bounds: [[f64::INFINITY; 3], [f64::NEG_INFINITY; 3]], centre, scale, least };
        // The boxes in the root nodes contain all triangles. Thin triangles have a separate root.
        let roots = [Some(&tree.nodes[0]), tree.nodes.get(tree.thin_root as usize)];
        for (node, slot) in
            roots.into_iter().flatten().flat_map(|node| (0..8).map(move |i| (node, i)))
        {
            let [lo, hi] = extent.child_box(node, slot);
            for k in 0..3 {
                extent.bounds[0][k] = extent.bounds[0][k].min(lo[k]);
                extent.bounds[1][k] = extent.bounds[1][k].max(hi[k]);
            }
        }
        extent
    }

    /// Returns the box of a node's child in mesh coordinates. For a missing child, the box runs
    /// from infinity to minus infinity.
    #[inline(always)]
    pub(super) fn child_box(&self, node: &Node, slot: usize) -> [[f64; 3]; 2] {
        [false, true].map(|upper| {
            [0, 1, 2].map(|axis| {
                f64::from(node.sides(axis, upper)[slot]) / self.scale + self.centre[axis]
            })
        })
    }

    /// Returns the largest magnitude of a coordinate along each axis, including that of the centre;
    /// 0 if there are no triangles.
    #[inline]
    pub(super) fn largest(&self) -> [f64; 3] {
        let ([lo, hi], centre) = (self.bounds, self.centre);
        let largest = |k: usize| lo[k].abs().max(hi[k].abs()).max(centre[k].abs());
        [0, 1, 2].map(|k| if lo[k] <= hi[k] { largest(k) } else { 0.0 })
    }

    /// Returns whether there are no triangles.
    pub(super) fn is_empty(&self) -> bool {
        self.bounds[0][0] > self.bounds[1][0]
    }
}
