//! The arithmetic of the mode `exact`: each tier against rationals, and the theorems on closed meshes.

#[path = "exact/cases.rs"]
mod cases;
#[path = "common/compare.rs"]
mod compare;
#[path = "exact/meshes.rs"]
mod meshes;
#[path = "exact/pairs.rs"]
mod pairs;
#[path = "exact/solids.rs"]
mod solids;
