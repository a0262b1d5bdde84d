//! The class behind Python's `Scene`: instances of meshes, queried with flat f64 arrays.

use std::sync::{Mutex, MutexGuard, PoisonError};

use bytemuck::{Pod, Zeroable};
use intertri::{Hit, Ray64};
use intertri_trace::{
    ClosestPoint, InstanceId, Scene, SceneClosestPoint, SceneError, SceneHit, SceneLoadError,
    SceneMesh, SceneSnapshot,
};
use numpy::{PyReadonlyArray1, PyReadwriteArray1};
use pyo3::exceptions::{PyIndexError, PyTypeError, PyValueError};
use pyo3::prelude::*;
use pyo3::types::PyBytes;

use crate::batch::answers;
use crate::lists::{Lists, lists};
use crate::output::{Bytes, FEW, Threads, rows};
use crate::part::Part;
use crate::points::{of_points, winding};
use crate::pool::Workers;
use crate::run::run;
use crate::scalar::no_memory;
use crate::source::{Arrays, Source};
use crate::tree::{Tree32, Tree64, small_or};

/// The size in bytes below which one thread loads a scene before other threads would wake up.
const SMALL_FILE: usize = 1 << 16;

/// A hit, as a row of a numpy array.
#[derive(Clone, Copy, Pod, Zeroable)]
#[repr(C)]
struct SceneRow {
    hit: Hit,
    instance: u32,
    leaves: u32,
}

impl From<SceneHit> for SceneRow {
    fn from(SceneHit { hit, instance, leaves }: SceneHit) -> Self {
        Self { hit, instance: instance.index() as u32, leaves: leaves.into() }
    }
}

/// A closest point, as a row of a numpy array.
#[derive(Clone, Copy, Pod, Zeroable)]
#[repr(C)]
struct PointRow {
    closest: ClosestPoint,
    instance: u32,
    _unused: u32,
}

impl From<SceneClosestPoint> for PointRow {
    fn from(SceneClosestPoint { closest, instance }: SceneClosestPoint) -> Self {
        Self { closest, instance: instance.index() as u32, _unused: 0 }
    }
}

/// The scene being edited and the last committed snapshot. A query keeps the snapshot with which it
/// started.
struct State {
    scene: Scene,
    snapshot: SceneSnapshot,
}

/// A scene of mesh instances.
#[pyclass(frozen, module = "intertri._intertri")]
pub(crate) struct NativeScene {
    state: Mutex<State>,
}

impl NativeScene {
    /// Locks the state. The lock is held only briefly and never while waiting for the interpreter's
    /// lock.
    fn state(&self) -> MutexGuard<'_, State> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Returns the last committed snapshot, restricted to the instances whose masks share a bit
    /// with `mask`.
    fn snapshot(&self, mask: u32) -> SceneSnapshot {
        self.state().snapshot.clone().mask(mask)
    }
}

/// Converts an error about an instance or a matrix to a Python exception.
fn refused(error: SceneError) -> PyErr {
    match error {
        SceneError::NoInstance(_) => PyIndexError::new_err(error.to_string()),
        SceneError::OutOfMemory => no_memory(error),
        error => PyValueError::new_err(error.to_string()),
    }
}

#[pymethods]
impl NativeScene {
    #[new]
    fn new() -> PyResult<Self> {
        let scene = Scene::new();
        let snapshot = scene.commit().map_err(refused)?;
        Ok(Self { state: Mutex::new(State { scene, snapshot }) })
    }

    fn __len__(&self) -> usize {
        self.state().scene.len()
    }

    /// Adds an instance of a mesh's hierarchy.
    fn add(&self, py: Python<'_>, tree: &Bound<'_, PyAny>, matrix: [f64; 12]) -> PyResult<usize> {
        let mesh: SceneMesh = if let Ok(tree) = tree.cast::<Tree32>() {
            tree.get().mesh.get(py)?.solid.shared_bvh().into()
        } else if let Ok(tree) = tree.cast::<Tree64>() {
            tree.get().mesh.get(py)?.solid.shared_bvh().into()
        } else {
            return Err(PyTypeError::new_err("an instance needs a hierarchy"));
        };
        let id = self.state().scene.add(mesh, matrix).map_err(refused)?;
        Ok(id.index())
    }

    /// Places several instances, or none if one of them does not exist.
    fn place(
        &self,
        instances: PyReadonlyArray1<'_, u32>,
        matrices: PyReadonlyArray1<'_, f64>,
    ) -> PyResult<()> {
        let (instances, matrices) = (instances.as_slice()?, matrices.as_slice()?);
        let (matrices, _) = matrices.as_chunks::<12>();
        if matrices.len() != instances.len() {
            return Err(PyValueError::new_err("there must be one matrix for each instance"));
        }
        let mut state = self.state();
        let mut ids = instances.iter().map(|&number| InstanceId::from_index(number));
        if let Some(id) = ids.find(|&id| !state.scene.contains(id)) {
            return Err(refused(SceneError::NoInstance(id)));
        }
        for (&number, matrix) in instances.iter().zip(matrices) {
            state.scene.place(InstanceId::from_index(number), *matrix).map_err(refused)?;
        }
        Ok(())
    }

    /// Removes an instance.
    fn remove(&self, instance: u32) -> PyResult<()> {
        self.state().scene.remove(InstanceId::from_index(instance)).map_err(refused)
    }

    /// Sets the mask of an instance.
    fn set_mask(&self, instance: u32, mask: u32) -> PyResult<()> {
        self.state().scene.set_mask(InstanceId::from_index(instance), mask).map_err(refused)
    }

    /// Commits the changes, so that later queries see them.
    fn commit(&self, py: Python<'_>, threads: Threads) -> PyResult<()> {
        let scene = self.state().scene.clone();
        let workers = Workers::new(threads, scene.len() <= 4096)?;
        let snapshot = run(py, &workers, |_| scene.commit())?.map_err(refused)?;
        self.state().snapshot = snapshot;
        Ok(())
    }

    /// Saves the scene to bytes, including uncommitted changes.
    fn to_bytes<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyBytes>> {
        let scene = self.state().scene.clone();
        let workers = Workers::new(None, scene.len() <= 4096)?;
        let bytes = run(py, &workers, |_| scene.try_to_bytes())?.map_err(no_memory)?;
        PyBytes::new_with(py, bytes.len(), |to| {
            to.copy_from_slice(&bytes);
            Ok(())
        })
    }

    /// Loads a scene from saved bytes and commits it.
    #[staticmethod]
    fn from_bytes(py: Python<'_>, bytes: &[u8]) -> PyResult<Self> {
        let workers = Workers::new(None, bytes.len() < SMALL_FILE)?;
        run(py, &workers, |_| {
            let scene = Scene::from_bytes(bytes).map_err(|error| match error {
                SceneLoadError::OutOfMemory => no_memory(error),
                error => PyValueError::new_err(error.to_string()),
            })?;
            let snapshot = scene.commit().map_err(refused)?;
            Ok(Self { state: Mutex::new(State { scene, snapshot }) })
        })?
    }

    /// Fills `out` with the closest hits.
    fn closest(
        &self,
        py: Python<'_>,
        rays: Arrays<'_, f64>,
        mask: u32,
        threads: Threads,
        mut out: Bytes<'_>,
    ) -> PyResult<()> {
        let rays = rays.source()?;
        let out: &mut [SceneRow] = rows(&mut out, rays.count)?;
        let (scene, workers) = (self.snapshot(mask), small_or(threads, &rays)?);
        answers(py, &workers, &rays, 0, (out, SceneHit::MISS.into()), |rays, _, hits| {
            let mut found = vec![SceneHit::MISS; rays.len()];
            scene.closest_batch_into(rays, &mut found);
            for (hit, found) in hits.iter_mut().zip(found) {
                *hit = found.into();
            }
        })
    }

    /// Stores in `out` whether each ray hits anything.
    fn any(
        &self,
        py: Python<'_>,
        rays: Arrays<'_, f64>,
        mask: u32,
        threads: Threads,
        mut out: PyReadwriteArray1<'_, bool>,
    ) -> PyResult<()> {
        let (rays, out) = (rays.source()?, out.as_slice_mut()?);
        if out.len() != rays.count {
            return Err(PyValueError::new_err("out has the wrong length"));
        }
        let (scene, workers) = (self.snapshot(mask), small_or(threads, &rays)?);
        answers(py, &workers, &rays, 0, (out, false), |rays, _, any| {
            scene.any_batch_into(rays, any);
        })
    }

    /// Returns every hit of each ray.
    fn all<'py>(
        &self,
        py: Python<'py>,
        rays: Arrays<'_, f64>,
        mask: u32,
        threads: Threads,
    ) -> PyResult<Lists<'py>> {
        let scene = self.snapshot(mask);
        listed(py, &rays.source()?, threads, |ray| scene.all(ray))
    }

    /// Returns every crossing of each ray.
    fn crossings<'py>(
        &self,
        py: Python<'py>,
        rays: Arrays<'_, f64>,
        mask: u32,
        threads: Threads,
    ) -> PyResult<Lists<'py>> {
        let scene = self.snapshot(mask);
        listed(py, &rays.source()?, threads, |ray| scene.crossings(ray))
    }

    /// Fills `out` with the closest points.
    fn closest_point(
        &self,
        py: Python<'_>,
        points: PyReadonlyArray1<'_, f64>,
        radius: f64,
        mask: u32,
        threads: Threads,
        mut out: Bytes<'_>,
    ) -> PyResult<()> {
        let points = points.as_slice()?;
        let out: &mut [PointRow] = rows(&mut out, points.len() / 3)?;
        let (scene, none) = (self.snapshot(mask), SceneClosestPoint::NONE);
        let workers = Workers::new(threads, points.len() < FEW)?;
        of_points(py, &workers, points, (out, none.into()), |points, out| {
            for (point, out) in points.iter().zip(out) {
                *out = scene.closest_point(*point, radius).unwrap_or(none).into();
            }
        })
    }

    /// Fills `out` with the winding numbers of points, or `SURFACE` for points on an instance.
    fn winding(
        &self,
        py: Python<'_>,
        points: PyReadonlyArray1<'_, f64>,
        mask: u32,
        threads: Threads,
        mut out: Bytes<'_>,
    ) -> PyResult<()> {
        let points = points.as_slice()?;
        let out: &mut [i32] = rows(&mut out, points.len() / 3)?;
        let scene = self.snapshot(mask);
        let workers = Workers::new(threads, points.len() < FEW)?;
        of_points(py, &workers, points, (out, 0), |points, out| {
            for (point, out) in points.iter().zip(out) {
                *out = winding(scene.classify(*point));
            }
        })
    }
}

/// Runs a query that returns a list of hits for each ray.
fn listed<'py>(
    py: Python<'py>,
    rays: &Source<'_, f64>,
    threads: Threads,
    ask: impl Fn(&Ray64) -> Vec<SceneHit> + Sync,
) -> PyResult<Lists<'py>> {
    lists(py, &small_or(threads, rays)?, rays, 0, |rays, _| {
        let mut part = Part::new();
        for ray in rays {
            let hits = ask(ray);
            part.reserve(1, hits.len())?;
            part.answers.extend(hits.into_iter().map(SceneRow::from));
            part.offsets.push(part.answers.len() as i64);
        }
        Ok(part)
    })
}
