//! The native part of the Python package `intertri`: it reads numpy's arrays, lets the interpreter's lock go, and
//! asks `intertri-trace` on all threads.

mod batch;
mod joined;
mod lists;
mod mesh;
mod part;
mod picture;
mod points;
mod pool;
mod run;
mod scalar;
mod source;
mod tree;

use pyo3::prelude::*;

/// What `intertri/_triangles.py` stands on; no part of the interface.
#[pymodule]
mod _intertri {
    use pyo3::prelude::*;

    #[pymodule_export]
    use crate::tree::{Tree32, Tree64};

    #[pymodule_init]
    fn init(module: &Bound<'_, PyModule>) -> PyResult<()> {
        module.add("__version__", env!("CARGO_PKG_VERSION"))?;
        module.add("SURFACE", crate::tree::SURFACE)
    }
}
