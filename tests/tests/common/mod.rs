//! What the tests share: the laboratory's families as scenes for the runner.

use intertri_lab::families::Family;
use intertri_lab::rng::Rng;
use intertri_tests::Scene;

/// Some triangles and rays of a family.
pub(crate) fn scene(family: &Family, rng: &mut Rng, triangles: usize, rays: usize) -> Scene {
    let scene = family.scene(rng, triangles, rays);
    Scene { triangles: scene.triangles, rays: scene.rays, threshold: scene.threshold }
}
