//! Scenes of triangles and rays, by every way to ask, against the reference.

use intertri::lanes::Level;

use super::input::Input;
use crate::{as_source, check_hierarchy, check_kernel};

/// Packets and packs of every mode, width, form and level.
pub fn kernel(bytes: &[u8]) {
    let scene = Input::new(bytes).scene(6, 6);
    check_kernel(&scene).unwrap_or_else(|why| panic!("{why}\n{}", as_source(&scene)));
}

/// The hierarchy, at the CPU's best level and in scalars.
pub fn hierarchy(bytes: &[u8]) {
    let scene = Input::new(bytes).scene(40, 10);
    check_hierarchy(&scene, &[Level::best(), Level::SCALAR])
        .unwrap_or_else(|why| panic!("{why}\n{}", as_source(&scene)));
}
