//! The native module of the Python package `intertri`. It reads numpy arrays, releases the
//! interpreter's lock, and calls `intertri-trace` on all threads.

mod batch;
mod defects;
mod joined;
mod lists;
mod media;
mod mesh;
mod output;
mod part;
mod picture;
mod points;
mod pool;
mod read;
mod run;
mod scalar;
mod scene;
mod shared;
mod skip;
mod source;
mod spawn;
mod tree;

use pyo3::prelude::*;

/// The module that the Python files build on. It is not part of the public interface.
#[pymodule]
mod _intertri {
    use numpy::PyReadonlyArray1;
    use pyo3::prelude::*;

    #[pymodule_export]
    use crate::media::{Media32, Media64};
    #[pymodule_export]
    use crate::read::read_model;
    #[pymodule_export]
    use crate::scene::NativeScene;
    #[pymodule_export]
    use crate::tree::{Tree32, Tree64};

    /// Returns the XXH64 checksum of a contiguous array of bytes. It detects damage, but not
    /// tampering.
    #[pyfunction]
    fn checksum(py: Python<'_>, bytes: PyReadonlyArray1<'_, u8>) -> PyResult<u64> {
        let bytes = bytes.as_slice()?;
        Ok(py.detach(|| intertri_trace::internal::checksum(bytes)))
    }

    #[pymodule_init]
    fn init(module: &Bound<'_, PyModule>) -> PyResult<()> {
        module.add("__version__", env!("CARGO_PKG_VERSION"))?;
        module.add("SURFACE", crate::points::SURFACE)
    }
}
