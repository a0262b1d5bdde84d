//! The arithmetic of the mode `exact`: each tier against rationals, and the theorems on closed meshes.

#[path = "exact/cases.rs"]
mod cases;
#[path = "exact/meshes.rs"]
mod meshes;
#[path = "exact/oracle.rs"]
mod oracle;
#[path = "exact/pairs.rs"]
mod pairs;
