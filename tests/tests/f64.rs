//! Tests f64 scenes: the arithmetic of each tier, meshes, hierarchies, and coordinates at which
//! other tracers lose hits.

mod bound;
mod cases;
mod certified;
pub(crate) mod hierarchy;
mod meshes;
mod nearest;
mod pairs;
mod saved;
mod spawn;
mod utm;
