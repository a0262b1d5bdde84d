//! A mesh that several threads query while another thread may refit it.

use std::sync::{Arc, Mutex, MutexGuard, PoisonError, TryLockError};

use intertri::TriangleOf;
use intertri_trace::RefitError;
use pyo3::prelude::*;

use crate::mesh::Mesh;
use crate::pool::Workers;
use crate::run::{Stop, run};
use crate::scalar::{Scalar, no_memory, wrong};

/// A mesh with its hierarchy, or `None` if the mesh was lost in a failed refit. A query keeps the
/// mesh with which it started.
pub(crate) struct Shared<S: Scalar>(Mutex<Option<Arc<Mesh<S>>>>);

impl<S: Scalar> Shared<S> {
    pub(crate) fn new(mesh: Mesh<S>) -> Self {
        Self(Mutex::new(Some(Arc::new(mesh))))
    }

    fn lock(&self) -> MutexGuard<'_, Option<Arc<Mesh<S>>>> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Returns the current mesh, after waiting for a refit in progress.
    pub(crate) fn get(&self, py: Python<'_>) -> PyResult<Arc<Mesh<S>>> {
        // If the thread need not wait, it keeps the interpreter's lock, so that no fork can happen
        // while the mesh's lock is held.
        let mesh = match self.0.try_lock() {
            Ok(mesh) => mesh.clone(),
            Err(_) => py.detach(|| self.lock().clone()),
        };
        mesh.ok_or_else(lost)
    }

    /// Moves the triangles and returns the estimated slowdown of rays compared with a new tree, as
    /// a factor. Queries that started earlier continue with the old mesh. The mesh is lost if a
    /// signal ends the refit or the refit itself runs out of memory.
    pub(crate) fn refit(
        &self,
        py: Python<'_>,
        workers: &Workers,
        triangles: impl FnOnce(&Stop) -> PyResult<Vec<TriangleOf<S>>> + Send,
    ) -> PyResult<f64> {
        let triangles = run(py, workers, triangles)??;
        // Take the lock on this thread: a pool thread that waits for other threads might start
        // another refit in the meantime.
        let mut place = loop {
            match self.0.try_lock() {
                Ok(place) => break place,
                Err(TryLockError::Poisoned(place)) => break place.into_inner(),
                // The thread that holds the lock may need the interpreter's lock to release the
                // mesh's lock.
                Err(TryLockError::WouldBlock) => py.detach(|| drop(self.lock())),
            }
        };
        let mesh = place.as_ref().ok_or_else(lost)?;
        let copy = match Arc::strong_count(mesh) {
            1 => None,
            // A query is still using the mesh, so refit a copy. If there is not enough memory for
            // one, the mesh stays as it was.
            _ => Some(run(py, workers, |_| mesh.try_clone())?.map_err(no_memory)?),
        };
        let mesh = place.take().and_then(Arc::into_inner).or(copy).ok_or_else(lost)?;
        let (mesh, ratio) = run(py, workers, |_| mesh.refit(&triangles))?;
        if ratio != Err(RefitError::OutOfMemory) {
            *place = Some(Arc::new(mesh));
        }
        ratio.map_err(|error| match error {
            RefitError::OutOfMemory => no_memory(error),
            _ => wrong(error),
        })
    }
}

/// Creates the error for a query on a mesh that was lost in a refit.
fn lost() -> PyErr {
    no_memory("a refit was interrupted or ran out of memory; repeat the query")
}
