//! Given in f32: the walk goes over the triangles and rays themselves.

use std::io::{self, Write};
use std::ops::Range;

use intertri::internal::Which;
use intertri::{Ray, Triangle};

use super::{Ask, Given, Progress};
use crate::build::BuildError;
use crate::memory::OutOfMemory;
use crate::nearest::{ClosestPoint, InF32, closest_points};
use crate::refit::{Refit, RefitError};
use crate::save::{self, Input, LoadError};
use crate::tree::Tree;

impl Given for f32 {
    type Originals = ();
    const PIECE: usize = usize::MAX;

    fn build(triangles: &[Triangle], progress: Progress<'_>) -> Result<(Tree, ()), BuildError> {
        Ok((Tree::over(triangles, progress)?, ()))
    }

    fn try_clone((): &()) -> Result<(), OutOfMemory> {
        Ok(())
    }

    #[inline]
    fn walk_one<A>(
        _: &Tree,
        (): &(),
        which: &Which<'_>,
        ray: &Ray,
        ask: impl FnOnce(&Which<'_>, &Ray) -> A,
    ) -> A {
        ask(which, ray)
    }

    #[inline]
    fn walk(
        _: &Tree,
        (): &(),
        which: &Which<'_>,
        (rays, some): (&[Ray], Range<usize>),
        ask: Ask<'_>,
    ) {
        ask(which, &rays[some]);
    }

    #[inline]
    fn triangle(tree: &Tree, (): &(), place: u32) -> Triangle {
        tree.triangle_in(place)
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

    fn refit_tree(
        tree: &mut Tree,
        (): &mut (),
        triangles: &[Triangle],
    ) -> Result<Refit, RefitError> {
        tree.refit(triangles)
    }

    fn write_tree(tree: &Tree, (): &(), output: &mut dyn Write) -> io::Result<()> {
        save::write(tree, output)
    }

    fn read_tree(input: &mut dyn Input) -> Result<(Tree, ()), LoadError> {
        Ok((save::read(input)?, ()))
    }
}
