//! Reads models from files.

use std::path::PathBuf;

use intertri_scene::{LoadedModel, load_model};
use numpy::PyArray1;
use pyo3::prelude::*;

use crate::run::run_apart;
use crate::scalar::{no_memory, wrong};

/// Vertices and faces as flat arrays, and a message for each kind of item that was omitted,
/// repaired, or guessed.
type Model<'py> = (Bound<'py, PyArray1<f64>>, Bound<'py, PyArray1<u32>>, Vec<String>);

/// Reads a model in f64.
#[pyfunction]
pub(crate) fn read_model(py: Python<'_>, path: PathBuf) -> PyResult<Model<'_>> {
    let loaded = run_apart(py, move || load_model::<f64>(&path))?;
    let LoadedModel { mesh, notes, .. } = loaded.map_err(|error| {
        // The loaders report that memory ran out only in the error's text.
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
