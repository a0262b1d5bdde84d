//! Finds the defects of a mesh, and the faces to turn so that the mesh is consistently oriented,
//! for Python's `inspect` and `orient`.

use intertri::TriangleOf;
use intertri_trace::{BvhScalar, MeshReport, Solid};
use numpy::PyArray1;
use pyo3::prelude::*;

use crate::scalar::no_memory;

pub(crate) type Numbers<'py> = Bound<'py, PyArray1<i64>>;

/// Describes the defects of a mesh in words and lists them. Open, turned, and uneven edges are
/// listed as a face and the corner where the edge starts. Doubled and opposed faces are listed with
/// the earlier face that they repeat.
pub(crate) fn defects<S: BvhScalar>(
    triangles: &[TriangleOf<S>],
) -> PyResult<(String, [Vec<i64>; 5])> {
    let report = Solid::inspect(triangles).map_err(no_memory)?;
    let MeshReport { open, turned, uneven, doubled, opposed } = &report;
    let [open, turned, uneven] = [open, turned, uneven]
        .map(|edges| edges.iter().flat_map(|edge| numbers([edge.triangle, edge.corner])).collect());
    let [doubled, opposed] = [doubled, opposed]
        .map(|faces| faces.iter().flat_map(|face| numbers([face.triangle, face.of])).collect());
    Ok((report.to_string(), [open, turned, uneven, doubled, opposed]))
}

/// Returns the triangles to turn so that each connected piece is oriented consistently and outward.
pub(crate) fn turned<S: BvhScalar>(triangles: &[TriangleOf<S>]) -> PyResult<Vec<i64>> {
    let turned = Solid::orient(triangles).map_err(no_memory)?.turned;
    Ok(turned.into_iter().map(|face| face as i64).collect())
}

fn numbers(row: [usize; 2]) -> [i64; 2] {
    row.map(|number| number as i64)
}
