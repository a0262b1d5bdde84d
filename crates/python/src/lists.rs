//! Lists of answers: any number a ray.

use bytemuck::Pod;
use intertri::RayOf;
use numpy::{PyArray1, PyArrayMethods};
use pyo3::exceptions::PyMemoryError;
use pyo3::prelude::*;
use rayon::ThreadPool;
use rayon::prelude::*;

use crate::part::Part;
use crate::picture::{Band, row_width};
use crate::run::{Stop, run};
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
    width: usize,
    ask: impl Fn(&[RayOf<S>]) -> PyResult<Part<A>> + Sync,
) -> PyResult<Lists<'py>> {
    let parts = run(py, pool, rays.count.saturating_mul(8), |stop| {
        if let Some(width) = row_width(rays, width) {
            return by_tiles(rays, width, &ask, stop);
        }
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

/// The lists of a picture with rows of so many pixels, band by band.
fn by_tiles<S: Scalar, A: Copy + Send + Sync>(
    rays: &Source<'_, S>,
    width: usize,
    ask: &(impl Fn(&[RayOf<S>]) -> PyResult<Part<A>> + Sync),
    stop: &Stop,
) -> PyResult<Vec<Part<A>>> {
    let whole = Band::new(width, rays.count);
    let starts = (0..rays.count).into_par_iter().step_by(whole.len());
    let part = |gathered: &mut Vec<RayOf<S>>, first: usize| {
        let band = whole.within(rays.count - first);
        let mut blocks = Vec::new();
        for block in band.blocks() {
            if stop.is_set() {
                return Ok(Part::new());
            }
            block.gather((rays, first), gathered);
            let found = ask(gathered)?;
            blocks.push((block, found.begins(), found));
        }
        let mut part = Part::new();
        for row in 0..band.rows() {
            for (block, begins, found) in &blocks {
                for (first, count) in block.fours(row) {
                    part.counts.extend_from_slice(&found.counts[first..first + count]);
                    let answers = &found.answers[begins[first]..begins[first + count]];
                    part.answers.extend_from_slice(answers);
                }
            }
        }
        let cut = first + band.len()..rays.count.min(first + whole.len());
        let found = ask(rays.rays(cut, gathered))?;
        part.counts.extend(found.counts);
        part.answers.extend(found.answers);
        Ok(part)
    };
    starts.map_init(Vec::new, part).collect()
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
