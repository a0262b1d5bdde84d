//! The f32 and f64 backends of `Bvh<S>`.
//!
//! ```text
//!   f32 ─────────────────────────────────────────────►┐
//!                                                     ├──► tree, filter, traversal, all in f32
//!   f64 ──► copies about the scene's centre ─────────►┘           │ undecided
//!      └──────────────────────────────────────────────► resolver ◄┘
//! ```

mod f32;
mod f64;
mod mesh64;

use std::fmt::Debug;
use std::io::{self, Write};
use std::ops::Range;

use intertri::simd::{Simd, Vec3};
use intertri::{Filter, LeafSlot, Mode, Ray, RayOf, Scalar, TriangleOf};

use crate::build::BuildError;
use crate::nearest::ClosestPoint;
use crate::refit::{Refit, RefitError};
use crate::save::{Input, LoadError};
use crate::tree::Tree;
use crate::util::memory::OutOfMemory;

/// A callback that is called occasionally during a build, with the number of triangles done and the
/// total.
pub(crate) type Progress<'a> = &'a (dyn Fn(usize, usize) + Sync);

/// A scalar type for the triangles and rays of a [`Bvh`](crate::Bvh): f32 or f64. This trait is
/// sealed.
pub trait BvhScalar: Backend {}

impl BvhScalar for core::primitive::f32 {}
impl BvhScalar for core::primitive::f64 {}

/// The operations of a hierarchy that differ between f32 and f64.
pub trait Backend: Scalar {
    /// The data stored with the tree. If the tree contains only copies, these are the original
    /// coordinates.
    type Originals: Clone + Debug + Send + Sync;

    /// The number of rays to copy per step, small enough that the copies stay in the cache.
    const PIECE: usize;

    /// Builds the tree and the data stored with it.
    fn build(
        triangles: &[TriangleOf<Self>],
        progress: Progress<'_>,
    ) -> Result<(Tree, Self::Originals), BuildError>;

    /// Clones the data stored with the tree. Returns an error if memory runs out.
    fn try_clone(originals: &Self::Originals) -> Result<Self::Originals, OutOfMemory>;

    /// Converts a ray to f32 and passes it to a traversal, along with its filter.
    fn with_ray<A>(
        tree: &Tree,
        originals: &Self::Originals,
        mode: Mode,
        ray: &RayOf<Self>,
        trace: impl FnOnce(&Filter<'_>, &Ray) -> A,
    ) -> A;

    /// Converts several rays of a batch to f32 and passes them to a traversal, along with their
    /// filter.
    fn with_rays<A>(
        tree: &Tree,
        originals: &Self::Originals,
        mode: Mode,
        rays: (&[RayOf<Self>], Range<usize>),
        trace: impl FnOnce(Filter<'_>, &[Ray]) -> A,
    ) -> A;

    /// Returns the original triangle in a slot of the tree's leaves.
    fn triangle(tree: &Tree, originals: &Self::Originals, slot: LeafSlot) -> TriangleOf<Self>;

    /// Returns the original corners of the triangles in a leaf. The values in lanes without a
    /// triangle are arbitrary.
    fn leaf_corners<L: Simd>(
        tree: &Tree,
        originals: &Self::Originals,
        leaf: usize,
    ) -> [Vec3<L::F64x8>; 3];

    /// Returns the centre and scale of the tree's units. In these units, a coordinate x has the
    /// value `(x - centre) * scale`.
    fn frame(originals: &Self::Originals) -> ([f64; 3], f64);

    /// Converts a point to the tree's units.
    fn point(originals: &Self::Originals, point: [Self; 3]) -> [f32; 3];

    /// Finds the closest point within a radius for each query point, on this thread.
    fn closest_points(
        tree: &Tree,
        originals: &Self::Originals,
        points: &[[Self; 3]],
        radius: f64,
        closest: &mut [ClosestPoint],
    );

    /// Moves the triangles.
    fn refit(
        tree: &mut Tree,
        originals: &mut Self::Originals,
        triangles: &[TriangleOf<Self>],
    ) -> Result<Refit, RefitError>;

    /// Writes the whole hierarchy.
    fn write(tree: &Tree, originals: &Self::Originals, output: &mut dyn Write) -> io::Result<()>;

    /// Reads a hierarchy written by `write`.
    fn read(input: &mut dyn Input) -> Result<(Tree, Self::Originals), LoadError>;
}
