//! The scalar types of coordinates, and queries that take a mode. [`named`] converts a mode's
//! Python name.

use intertri::{Hit, Hit32, Mode, RayOf};
use intertri_trace::{BvhScalar, MeshTriangle, Query};
use numpy::Element;
use pyo3::exceptions::{PyMemoryError, PyValueError};
use pyo3::{PyErr, PyResult};

use crate::part::Part;

/// A scalar type of coordinates: f32 or f64.
pub(crate) trait Scalar: Element + BvhScalar {
    /// Whether the type supports the `certified` mode.
    const HAS_CERTIFIED: bool;

    /// Sets a query's mode to one that [`named`] accepts.
    fn in_mode(query: Query<'_, Self>, mode: Mode) -> Query<'_, Self>;
}

impl Scalar for f32 {
    const HAS_CERTIFIED: bool = true;

    fn in_mode(query: Query<'_, Self>, mode: Mode) -> Query<'_, Self> {
        query.mode(mode)
    }
}

impl Scalar for f64 {
    const HAS_CERTIFIED: bool = false;

    fn in_mode(query: Query<'_, Self>, _: Mode) -> Query<'_, Self> {
        query
    }
}

/// Returns the mode with the given name, or an error if the scalar type does not support it.
pub(crate) fn named<S: Scalar>(name: &str) -> PyResult<Mode> {
    match name {
        "exact" => Ok(Mode::exact()),
        "certified" if S::HAS_CERTIFIED => Ok(Mode::certified()),
        "certified" => Err(PyValueError::new_err(
            "mode 'certified' requires float32 vertices and rays, but these are float64",
        )),
        _ => {
            Err(PyValueError::new_err(format!("mode {name:?} is neither 'exact' nor 'certified'")))
        }
    }
}

/// Finds the closest hits. A single ray is traced directly, without the preparation that a batch
/// needs.
pub(crate) fn closest<S: Scalar>(query: &mut Query<'_, S>, rays: &[RayOf<S>], hits: &mut [Hit]) {
    if let ([ray], [to]) = (rays, &mut *hits) {
        *to = query.closest(ray).unwrap_or(Hit::MISS);
    } else {
        query.closest_batch_into(rays, hits);
    }
}

/// Like [`closest`], but with t, u, and v in f32.
pub(crate) fn closest32<S: Scalar>(
    query: &mut Query<'_, S>,
    rays: &[RayOf<S>],
    hits: &mut [Hit32],
) {
    if let ([ray], [to]) = (rays, &mut *hits) {
        *to = query.closest32(ray).unwrap_or(Hit32::MISS);
    } else {
        query.closest_batch_into(rays, hits);
    }
}

/// The number of triangles to copy at a time, small enough for them to stay in the cache.
const SOME: usize = 1 << 12;

/// Finds the triangles of the closest hits in one mesh, or `u32::MAX` for none.
pub(crate) fn triangles<S: Scalar>(query: &mut Query<'_, S>, rays: &[RayOf<S>], to: &mut [u32]) {
    if let ([ray], [to]) = (rays, &mut *to) {
        *to = query.closest_triangle(ray).unwrap_or(MeshTriangle::MISS).triangle;
        return;
    }
    // Process the rays part by part on this thread, because the caller has already distributed them
    // among threads.
    let mut some = vec![MeshTriangle::MISS; rays.len().min(SOME)];
    for (rays, to) in rays.chunks(SOME).zip(to.chunks_mut(SOME)) {
        let some = &mut some[..rays.len()];
        query.closest_triangle_batch_into(rays, some);
        to.iter_mut().zip(some).for_each(|(to, found)| *to = found.triangle);
    }
}

/// Checks whether each ray hits anything.
pub(crate) fn any<S: Scalar>(query: &mut Query<'_, S>, rays: &[RayOf<S>], any: &mut [bool]) {
    if let ([ray], [to]) = (rays, &mut *any) {
        *to = query.any(ray);
    } else {
        query.any_batch_into(rays, any);
    }
}

/// Finds every hit of each ray.
pub(crate) fn all<S: Scalar>(
    query: &Query<'_, S>,
    rays: &[RayOf<S>],
    limit: Option<usize>,
) -> PyResult<Part<Hit>> {
    let lists = query.all_batch(rays, limit).map_err(no_memory)?;
    Ok(Part { offsets: lists.offsets, answers: lists.items })
}

pub(crate) fn no_memory(error: impl ToString) -> PyErr {
    PyMemoryError::new_err(error.to_string())
}

pub(crate) fn wrong(error: impl ToString) -> PyErr {
    PyValueError::new_err(error.to_string())
}
