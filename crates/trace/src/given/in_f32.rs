//! Given in f32: the walk goes over the triangles and rays themselves.

use intertri::internal::Which;
use intertri::{Ray, Triangle};

use super::{Ask, Given, Progress};
use crate::build::BuildError;
use crate::tree::Tree;

impl Given for f32 {
    type Originals = ();
    const PIECE: usize = usize::MAX;

    fn build(triangles: &[Triangle], progress: Progress<'_>) -> Result<(Tree, ()), BuildError> {
        Ok((Tree::over(triangles, progress)?, ()))
    }

    #[inline]
    fn walk(_: &Tree, (): &(), which: Which<'_>, rays: &[Ray], ask: Ask<'_>) {
        ask(which, rays);
    }

    #[inline]
    fn triangle(tree: &Tree, (): &(), place: u32) -> Triangle {
        tree.triangle_in(place)
    }

    #[inline]
    fn point((): &(), point: [f32; 3]) -> [f32; 3] {
        point
    }
}
