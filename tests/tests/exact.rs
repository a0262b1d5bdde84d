//! The arithmetic of the mode `exact`: each tier against rationals, and the theorems on closed meshes.

mod cases;
mod meshes;
mod pairs;
pub(crate) mod solids;
