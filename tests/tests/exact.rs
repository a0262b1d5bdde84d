//! Tests the arithmetic of the `exact` mode: compares each tier with rational arithmetic, and
//! checks the theorems of `docs/numerics/exact.md` on closed meshes.

mod cases;
mod meshes;
mod pairs;
pub(crate) mod solids;
