//! Creates rays that start at hits.

use intertri::{Hit, TriangleOf, spawn_ray};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;

use crate::pool::{Workers, chunks};
use crate::run::run;
use crate::scalar::Scalar;

/// The number of hits that a thread takes at a time.
const CHUNK: usize = 4096;

/// Fills `out` with rays, each an origin and a direction. Each ray starts at a hit on a face and
/// never hits that face again. The origins are NaN for misses.
pub(crate) fn spawn_rays<S: Scalar>(
    py: Python<'_>,
    workers: &Workers,
    (vertices, faces): (&[S], &[u32]),
    (hits, directions): (&[Hit], &[S]),
    out: &mut [S],
) -> PyResult<()> {
    let (vertices, faces): (&[[S; 3]], &[[u32; 3]]) = (vertices.as_chunks().0, faces.as_chunks().0);
    let (directions, out) = (directions.as_chunks::<3>().0, out.as_chunks_mut::<6>().0);
    if out.len() != hits.len() || directions.len() != hits.len() {
        return Err(PyValueError::new_err("out has the wrong length"));
    }
    let origin = |hit: &Hit, dir: [S; 3]| {
        let face = faces.get(hit.triangle as usize)?;
        let corner = |k: usize| vertices.get(face[k] as usize).copied();
        let triangle = TriangleOf([corner(0)?, corner(1)?, corner(2)?]);
        Some(spawn_ray(hit, &triangle, dir).origin)
    };
    run(py, workers, |_| {
        chunks(
            out,
            CHUNK,
            || (),
            |(), number, out| {
                let asked = hits.iter().zip(directions).skip(number * CHUNK);
                for (to, (hit, &dir)) in out.iter_mut().zip(asked) {
                    let [x, y, z] = origin(hit, dir).unwrap_or([S::from(f32::NAN); 3]);
                    *to = [x, y, z, dir[0], dir[1], dir[2]];
                }
            },
        );
    })
}
