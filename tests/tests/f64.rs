//! Given in f64: the arithmetic of each tier against rationals, meshes, hierarchies, and the coordinates that users
//! of other tracers lose.

#[path = "f64/bound.rs"]
mod bound;
#[path = "f64/cases.rs"]
mod cases;
#[path = "nearest/truth.rs"]
mod closest_truth;
#[path = "common/compare.rs"]
mod compare;
#[path = "f64/hierarchy.rs"]
mod hierarchy;
#[path = "f64/leave.rs"]
mod leave;
#[path = "f64/meshes.rs"]
mod meshes;
#[path = "f64/nearest.rs"]
mod nearest;
#[path = "f64/pairs.rs"]
mod pairs;
#[path = "f64/saved.rs"]
mod saved;
#[path = "f64/utm.rs"]
mod utm;
