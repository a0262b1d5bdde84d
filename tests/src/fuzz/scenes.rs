//! Compares the kernel and the hierarchy with the reference implementation, on scenes generated
//! from bytes.

use intertri::simd::Level;

use super::input::Input;
use crate::{as_source, check_hierarchy, check_kernel};

/// Checks the kernel in every mode, form and width, and at every SIMD level.
pub fn kernel(bytes: &[u8]) {
    let scene = Input::new(bytes).scene(6, 6);
    let levels: Vec<Level> = Level::all().collect();
    check_kernel(&scene, &levels).unwrap_or_else(|why| panic!("{why}\n{}", as_source(&scene)));
}

/// Checks the hierarchy at the CPU's best SIMD level and at the portable level.
pub fn hierarchy(bytes: &[u8]) {
    let mut input = Input::new(bytes);
    let mut scene = input.scene(40, 10);

    // Half of the time, move all rays to one origin and keep their targets, so that they form a
    // bundle.
    if input.below(2) == 1 {
        let origin = scene.rays[0].origin;
        for ray in &mut scene.rays {
            ray.dir = [0, 1, 2].map(|k| ray.origin[k] - origin[k] + ray.dir[k]);
            ray.origin = origin;
        }
    }
    check_hierarchy(&scene, &[Level::best(), Level::PORTABLE])
        .unwrap_or_else(|why| panic!("{why}\n{}", as_source(&scene)));
}
