//! Tests the arithmetic of the `exact` mode: each tier is compared with rational arithmetic, and
//! the theorems of `docs/numerics/exact.md` are checked on closed meshes.

mod cases;
mod meshes;
mod pairs;
pub(crate) mod solids;
