//! In which scalar triangles and rays are given, and what the walk makes of them.
//!
//! ```text
//!   f32 ─────────────────────────────────────────────►┐
//!                                                     ├──► tree, filter, walk, all in f32
//!   f64 ──► copies about the scene's centre ─────────►┘           │ undecided
//!      └──────────────────────────────────────────────► resolver ◄┘
//! ```

mod in_f32;
mod in_f64;
mod mesh64;

use std::fmt::Debug;
use std::io::{self, Write};
use std::ops::Range;

use intertri::internal::Which;
use intertri::{Exact, Mode, Ray, RayOf, Scalar, TriangleOf};

use crate::build::BuildError;
use crate::memory::OutOfMemory;
use crate::nearest::ClosestPoint;
use crate::refit::{Refit, RefitError};
use crate::save::{Input, LoadError};
use crate::tree::Tree;

/// What is told of a build: how many triangles are done, of how many.
pub(crate) type Progress<'a> = &'a (dyn Fn(usize, usize) + Sync);

/// What the walk is asked: of rays as it goes over them, and by which test.
pub(crate) type Ask<'a> = &'a mut dyn FnMut(&Which<'_>, &[Ray]);

/// A scalar in which a hierarchy's triangles and rays may be given: f32 or f64. The set is closed.
pub trait Given: Scalar {
    /// What is kept beside the tree.
    #[doc(hidden)]
    type Originals: Clone + Debug + Send + Sync;

    /// Rays that the walk is asked about at a time.
    #[doc(hidden)]
    const PIECE: usize;

    /// The tree over triangles, and what is kept beside it.
    #[doc(hidden)]
    fn build(
        triangles: &[TriangleOf<Self>],
        progress: Progress<'_>,
    ) -> Result<(Tree, Self::Originals), BuildError>;

    /// A copy of what is kept, if there is memory for it.
    #[doc(hidden)]
    fn try_clone(originals: &Self::Originals) -> Result<Self::Originals, OutOfMemory>;

    /// Asks about one ray.
    #[doc(hidden)]
    fn walk_one<A>(
        tree: &Tree,
        originals: &Self::Originals,
        which: &Which<'_>,
        ray: &RayOf<Self>,
        ask: impl FnOnce(&Which<'_>, &Ray) -> A,
    ) -> A;

    /// Asks about some of the rays of a call.
    #[doc(hidden)]
    fn walk(
        tree: &Tree,
        originals: &Self::Originals,
        which: &Which<'_>,
        rays: (&[RayOf<Self>], Range<usize>),
        ask: Ask<'_>,
    );

    /// The triangle in a place of the tree's leaves.
    #[doc(hidden)]
    fn triangle(tree: &Tree, originals: &Self::Originals, place: u32) -> TriangleOf<Self>;

    /// Where a point lies in the tree's boxes.
    #[doc(hidden)]
    fn point(originals: &Self::Originals, point: [Self; 3]) -> [f32; 3];

    /// The closest points of some, on this thread, where they are not farther than a radius.
    #[doc(hidden)]
    fn closest_points(
        tree: &Tree,
        originals: &Self::Originals,
        points: &[[Self; 3]],
        radius: f64,
        closest: &mut [ClosestPoint],
    );

    /// Moves the triangles.
    #[doc(hidden)]
    fn refit_tree(
        tree: &mut Tree,
        originals: &mut Self::Originals,
        triangles: &[TriangleOf<Self>],
    ) -> Result<Refit, RefitError>;

    /// Writes all of it.
    #[doc(hidden)]
    fn write_tree(
        tree: &Tree,
        originals: &Self::Originals,
        output: &mut dyn Write,
    ) -> io::Result<()>;

    /// Reads what was written.
    #[doc(hidden)]
    fn read_tree(input: &mut dyn Input) -> Result<(Tree, Self::Originals), LoadError>;
}

/// A mode that answers for triangles and rays given in a scalar: every mode for f32, and for f64 the mode
/// [`Exact`].
///
/// `certified` and `double` promise what the scalar f64 reference says of coordinates in f32, and `fixed` has a grid
/// of its own: of f64 that is nothing.
#[diagnostic::on_unimplemented(
    message = "`{Self}` does not answer for `{S}`",
    note = "hierarchies over f64 are asked by the mode `Exact`"
)]
pub trait ModeFor<S>: Copy + Send + Sync {
    /// Its test.
    #[doc(hidden)]
    fn which(&self) -> Which<'static>;
}

impl<M: Mode> ModeFor<f32> for M {
    #[inline]
    fn which(&self) -> Which<'static> {
        self.test().into()
    }
}

impl ModeFor<f64> for Exact {
    #[inline]
    fn which(&self) -> Which<'static> {
        self.test().into()
    }
}
