//! Query arguments besides points and rays: the thread count and the output buffer.

use std::num::NonZeroUsize;

use numpy::PyReadwriteArray1;
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;

pub(crate) type Threads = Option<NonZeroUsize>;
pub(crate) type Bytes<'py> = PyReadwriteArray1<'py, u8>;

/// One thread finishes up to this many rays or triangles before other threads would wake up.
pub(crate) const SMALL: usize = 4096;

/// The corresponding limit for points, as a number of coordinates: 32 points.
pub(crate) const FEW: usize = 3 * 32;

/// Casts bytes to answers.
pub(crate) fn rows<'a, A: bytemuck::Pod>(
    bytes: &'a mut Bytes<'_>,
    count: usize,
) -> PyResult<&'a mut [A]> {
    let bytes = bytes.as_slice_mut()?;
    if bytes.is_empty() && count == 0 {
        return Ok(&mut []);
    }
    let rows: &mut [A] = bytemuck::try_cast_slice_mut(bytes)
        .map_err(|error| PyValueError::new_err(format!("out cannot be filled: {error}")))?;
    if rows.len() == count {
        Ok(rows)
    } else {
        Err(PyValueError::new_err("out has the wrong length"))
    }
}
