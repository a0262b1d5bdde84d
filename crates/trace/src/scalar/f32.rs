//! The f32 backend: traversal uses the given triangles and rays directly.

use std::io::{self, Write};
use std::ops::Range;

use intertri::simd::{Simd, Vec3};
use intertri::{Filter, LeafSlot, Mode, Ray, Triangle};

use super::{Backend, Progress};
use crate::build::BuildError;
use crate::nearest::{ClosestPoint, InF32, closest_points};
use crate::refit::{Refit, RefitError};
use crate::save::{self, Input, LoadError};
use crate::tree::Tree;
use crate::util::memory::OutOfMemory;

impl Backend for f32 {
    type Originals = ();
    const PIECE: usize = usize::MAX;

    fn build(triangles: &[Triangle], progress: Progress<'_>) -> Result<(Tree, ()), BuildError> {
        // The leaves contain the triangles themselves, so there are no originals to keep.
        Ok((Tree::over(triangles, progress)?, ()))
    }

    fn try_clone((): &()) -> Result<(), OutOfMemory> {
        Ok(())
    }

    #[inline]
    fn with_ray<A>(
        _: &Tree,
        (): &(),
        mode: Mode,
        ray: &Ray,
        trace: impl FnOnce(&Filter<'_>, &Ray) -> A,
    ) -> A {
        trace(&mode.filter(), ray)
    }

    #[inline]
    fn with_rays<A>(
        _: &Tree,
        (): &(),
        mode: Mode,
        (rays, some): (&[Ray], Range<usize>),
        trace: impl FnOnce(Filter<'_>, &[Ray]) -> A,
    ) -> A {
        trace(mode.filter(), &rays[some])
    }

    #[inline]
    fn triangle(tree: &Tree, (): &(), slot: LeafSlot) -> Triangle {
        tree.triangle_in(slot)
    }

    #[inline(always)]
    fn leaf_corners<L: Simd>(tree: &Tree, (): &(), leaf: usize) -> [Vec3<L::F64x8>; 3] {
        let [a, b, c] = tree.leaves[leaf].block.corners();
        [Vec3::load_f32(a), Vec3::load_f32(b), Vec3::load_f32(c)]
    }

    fn frame((): &()) -> ([f64; 3], f64) {
        ([0.0; 3], 1.0)
    }

    #[inline]
    fn point((): &(), point: [f32; 3]) -> [f32; 3] {
        point
    }

    fn closest_points(
        tree: &Tree,
        (): &(),
        points: &[[f32; 3]],
        radius: f64,
        closest: &mut [ClosestPoint],
    ) {
        closest_points(InF32(tree), points, radius, closest);
    }

    fn refit(tree: &mut Tree, (): &mut (), triangles: &[Triangle]) -> Result<Refit, RefitError> {
        tree.refit(triangles)
    }

    fn write(tree: &Tree, (): &(), output: &mut dyn Write) -> io::Result<()> {
        save::write(tree, output)
    }

    fn read(input: &mut dyn Input) -> Result<(Tree, ()), LoadError> {
        Ok((save::read(input)?, ()))
    }
}
