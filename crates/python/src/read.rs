//! Reads models from files, for Python's `Mesh.read`.

use std::path::PathBuf;

use intertri_scene::{LoadedModel, load_model};
use numpy::PyArray1;
use pyo3::prelude::*;

use crate::run::run_apart;
use crate::scalar::{no_memory, wrong};

/// Vertices and faces as flat arrays, and a message for each kind of item that was omitted,
/// repaired, or guessed.
type Model<'py> = (Bound<'py, PyArray1<f64>>, Bound<'py, PyArray1<u32>>, Vec<String>);

/// Reads a model with f64 coordinates.
#[pyfunction]
pub(crate) fn read_model(py: Python<'_>, path: PathBuf) -> PyResult<Model<'_>> {
    let loaded = run_apart(py, move || load_model::<f64>(&path))?;
    let LoadedModel { mesh, notes, .. } = loaded.map_err(|error| {
        // Only the error's text shows whether a loader ran out of memory.
        if error.cause.contains("more memory than is available") {
            no_memory(error)
        } else {
            wrong(error)
        }
    })?;
    let vertices = PyArray1::from_vec(py, mesh.positions.into_flattened());
    let faces = PyArray1::from_vec(py, mesh.triangles.into_flattened());
    Ok((vertices, faces, notes.as_slice().iter().map(ToString::to_string).collect()))
}
