//! Lists of answers: any number a ray.

use bytemuck::Pod;
use intertri::RayOf;
use numpy::{PyArray1, PyArrayMethods};
use pyo3::exceptions::PyMemoryError;
use pyo3::prelude::*;
use rayon::ThreadPool;
use rayon::prelude::*;

use crate::part::Part;
use crate::run::run;
use crate::scalar::Scalar;
use crate::source::Source;

/// Rays a thread takes at a time.
const CHUNK: usize = 4096;

/// Where each ray's answers begin, and after the last where they end; and the bytes of the answers.
pub(crate) type Lists<'py> = (Bound<'py, PyArray1<i64>>, Bound<'py, PyArray1<u8>>);

/// Asks for a list a ray.
pub(crate) fn lists<'py, S: Scalar, A: Pod + Send + Sync>(
    py: Python<'py>,
    pool: &ThreadPool,
    rays: &Source<'_, S>,
    ask: impl Fn(&[RayOf<S>]) -> PyResult<Part<A>> + Sync,
) -> PyResult<Lists<'py>> {
    let parts = run(py, pool, rays.count.saturating_mul(8), |stop| {
        let starts = (0..rays.count).into_par_iter().step_by(CHUNK);
        let part = |gathered: &mut Vec<RayOf<S>>, first: usize| {
            if stop.is_set() {
                return Ok(Part::new());
            }
            ask(rays.rays(first..(first + CHUNK).min(rays.count), gathered))
        };
        starts.map_init(Vec::new, part).collect::<PyResult<Vec<Part<A>>>>()
    })??;

    let total: usize = parts.iter().map(|part| part.answers.len()).sum();
    let offsets = zeros::<i64>(py, rays.count + 1)?;
    let answers = zeros::<u8>(py, total * size_of::<A>())?;
    {
        let mut offsets = offsets.readwrite();
        let mut answers = answers.readwrite();
        let (offsets, answers) = (offsets.as_slice_mut()?, answers.as_slice_mut()?);
        py.detach(|| {
            let mut sum = 0;
            let counts = parts.iter().flat_map(|part| &part.counts);
            for (offset, count) in offsets[1..].iter_mut().zip(counts) {
                sum += i64::from(*count);
                *offset = sum;
            }
            let mut rest = answers;
            let places: Vec<_> = parts
                .iter()
                .map(|part| {
                    let bytes = size_of_val(&part.answers[..]);
                    let (place, others) = std::mem::take(&mut rest).split_at_mut(bytes);
                    rest = others;
                    (part, place)
                })
                .collect();
            pool.install(|| {
                places.into_par_iter().for_each(|(part, place)| {
                    place.copy_from_slice(bytemuck::cast_slice(&part.answers));
                });
            });
        });
    }
    Ok((offsets, answers))
}

/// An array of zeros, or an error where there is no memory.
fn zeros<T: numpy::Element>(py: Python<'_>, count: usize) -> PyResult<Bound<'_, PyArray1<T>>> {
    // `numpy`'s own call panics where memory ends.
    let mut probe: Vec<T> = Vec::new();
    probe.try_reserve_exact(count).map_err(|_| {
        PyMemoryError::new_err(format!("{count} answers need more memory than there is"))
    })?;
    drop(probe);
    Ok(PyArray1::zeros(py, count, false))
}
