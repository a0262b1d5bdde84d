//! The classes behind Python's `Mesh`: a hierarchy over f32 or f64 triangles, queried with flat
//! arrays.
//!
//! `intertri/_arrays.py` checks users' arguments. This module repeats only the checks on which
//! memory safety depends.

use std::time::Instant;

use intertri::{Crossings, Hit, Hit32, Mode, RayOf, TriangleOf};
use intertri_trace::{ClosestPoint, Containment, Solid, SolidError};
use numpy::{PyArray1, PyReadonlyArray1, PyReadwriteArray1};
use pyo3::exceptions::{PyIndexError, PyMemoryError, PyValueError};
use pyo3::prelude::*;
use pyo3::types::PyBytes;

use crate::batch::answers;
use crate::defects::{Numbers, defects, turned};
use crate::lists::{Lists, lists};
use crate::mesh::Mesh;
use crate::output::{Bytes, FEW, SMALL, Threads, rows};
use crate::picture::tiled;
use crate::points::{grid, of_points, of_solid, winding};
use crate::pool::Workers;
use crate::run::{Stop, run};
use crate::scalar::{Scalar, all, any, closest, closest32, named, no_memory, triangles, wrong};
use crate::shared::Shared;
use crate::skip::without;
use crate::source::{Arrays, Source};
use crate::spawn::spawn_rays;

/// Returns the threads that trace the given rays. If there are few rays, this is only the calling
/// thread.
pub(crate) fn small_or<S: Scalar>(threads: Threads, rays: &Source<'_, S>) -> PyResult<Workers> {
    Workers::new(threads, rays.count <= SMALL)
}

/// The number of faces gathered between two checks for signals.
const STEP: usize = 1 << 16;

/// Gathers the corners of faces as triangles. Ends early if `stop` is set.
pub(crate) fn gather<S: Scalar>(
    vertices: &[S],
    faces: &[u32],
    stop: &Stop,
) -> PyResult<Vec<TriangleOf<S>>> {
    let vertices: &[[S; 3]] = vertices.as_chunks().0;
    let faces: &[[u32; 3]] = faces.as_chunks().0;
    let mut triangles = Vec::new();
    triangles.try_reserve_exact(faces.len()).map_err(|_| {
        PyMemoryError::new_err(format!(
            "{} triangles need more memory than is available",
            faces.len()
        ))
    })?;
    for faces in faces.chunks(STEP).take_while(|_| !stop.is_set()) {
        for face in faces {
            let corner = |k: usize| vertices.get(face[k] as usize).copied();
            let (Some(a), Some(b), Some(c)) = (corner(0), corner(1), corner(2)) else {
                return Err(PyIndexError::new_err(format!("face {face:?} is out of range")));
            };
            triangles.push(TriangleOf([a, b, c]));
        }
    }
    Ok(triangles)
}

/// Defines a class for one scalar type, because a generic type cannot be a Python class.
macro_rules! tree {
    ($name:ident, $scalar:ty) => {
        /// A hierarchy over triangles.
        #[pyclass(frozen, module = "intertri._intertri")]
        pub(crate) struct $name {
            pub(crate) mesh: Shared<$scalar>,
        }

        #[pymethods]
        impl $name {
            #[new]
            fn new(
                py: Python<'_>,
                vertices: PyReadonlyArray1<'_, $scalar>,
                faces: PyReadonlyArray1<'_, u32>,
                threads: Threads,
            ) -> PyResult<Self> {
                let (vertices, faces) = (vertices.as_slice()?, faces.as_slice()?);
                let workers = Workers::new(threads, faces.len() < 3 * SMALL)?;
                let build = |stop: &_| Mesh::new(&gather(vertices, faces, stop)?);
                Ok(Self { mesh: Shared::new(run(py, &workers, build)??) })
            }

            /// Returns whether a mesh is closed.
            #[staticmethod]
            fn is_closed(
                py: Python<'_>,
                vertices: PyReadonlyArray1<'_, $scalar>,
                faces: PyReadonlyArray1<'_, u32>,
            ) -> PyResult<bool> {
                let (vertices, faces) = (vertices.as_slice()?, faces.as_slice()?);
                let workers = Workers::new(None, faces.len() < 3 * SMALL)?;
                run(py, &workers, |stop| {
                    let triangles = gather::<$scalar>(vertices, faces, stop)?;
                    match Solid::check_closed(&triangles) {
                        Err(SolidError::Build(error)) => Err(no_memory(error)),
                        closed => Ok(closed.is_ok()),
                    }
                })?
            }

            /// Describes the defects of a mesh and lists them as rows of two numbers.
            #[staticmethod]
            fn inspect<'py>(
                py: Python<'py>,
                vertices: PyReadonlyArray1<'_, $scalar>,
                faces: PyReadonlyArray1<'_, u32>,
            ) -> PyResult<(String, [Numbers<'py>; 5])> {
                let (vertices, faces) = (vertices.as_slice()?, faces.as_slice()?);
                let workers = Workers::new(None, faces.len() < 3 * SMALL)?;
                let work = |stop: &Stop| defects(&gather::<$scalar>(vertices, faces, stop)?);
                let (text, lists) = run(py, &workers, work)??;
                Ok((text, lists.map(|list| PyArray1::from_vec(py, list))))
            }

            /// Returns the faces to turn so that each connected piece is oriented consistently and
            /// outward.
            #[staticmethod]
            fn orient<'py>(
                py: Python<'py>,
                vertices: PyReadonlyArray1<'_, $scalar>,
                faces: PyReadonlyArray1<'_, u32>,
            ) -> PyResult<Numbers<'py>> {
                let (vertices, faces) = (vertices.as_slice()?, faces.as_slice()?);
                let workers = Workers::new(None, faces.len() < 3 * SMALL)?;
                let work = |stop: &Stop| turned(&gather::<$scalar>(vertices, faces, stop)?);
                Ok(PyArray1::from_vec(py, run(py, &workers, work)??))
            }

            /// Fills `out` with the closest hits, with t, u, and v in f32 or f64.
            fn closest(
                &self,
                py: Python<'_>,
                rays: Arrays<'_, $scalar>,
                mode: &str,
                threads: Threads,
                width: usize,
                in_f32: bool,
                mut out: Bytes<'_>,
            ) -> PyResult<()> {
                let (mode, rays) = (named::<$scalar>(mode)?, rays.source()?);
                let (workers, mesh) = (small_or(threads, &rays)?, self.mesh.get(py)?);
                if in_f32 {
                    let out: (&mut [Hit32], _) = (rows(&mut out, rays.count)?, Hit32::MISS);
                    answers(py, &workers, &rays, width, out, |rays, skip, hits| {
                        without(mesh.solid.bvh(), mode, skip, |query| closest32(query, rays, hits));
                    })
                } else {
                    let out: (&mut [Hit], _) = (rows(&mut out, rays.count)?, Hit::MISS);
                    answers(py, &workers, &rays, width, out, |rays, skip, hits| {
                        without(mesh.solid.bvh(), mode, skip, |query| closest(query, rays, hits));
                    })
                }
            }

            /// Fills `out` with the triangles of the closest hits.
            fn triangles(
                &self,
                py: Python<'_>,
                rays: Arrays<'_, $scalar>,
                mode: &str,
                threads: Threads,
                width: usize,
                mut out: Bytes<'_>,
            ) -> PyResult<()> {
                let (mode, rays) = (named::<$scalar>(mode)?, rays.source()?);
                let out: &mut [u32] = rows(&mut out, rays.count)?;
                let mesh = self.mesh.get(py)?;
                answers(py, &small_or(threads, &rays)?, &rays, width, (out, 0), |rays, skip, to| {
                    without(mesh.solid.bvh(), mode, skip, |query| triangles(query, rays, to));
                })
            }

            /// Stores in `out` whether each ray hits anything.
            fn any(
                &self,
                py: Python<'_>,
                rays: Arrays<'_, $scalar>,
                mode: &str,
                threads: Threads,
                width: usize,
                mut out: PyReadwriteArray1<'_, bool>,
            ) -> PyResult<()> {
                let (mode, rays) = (named::<$scalar>(mode)?, rays.source()?);
                let out = out.as_slice_mut()?;
                if out.len() != rays.count {
                    return Err(PyValueError::new_err("out has the wrong length"));
                }
                let mesh = self.mesh.get(py)?;
                answers(
                    py,
                    &small_or(threads, &rays)?,
                    &rays,
                    width,
                    (out, false),
                    |rays, skip, to| {
                        without(mesh.solid.bvh(), mode, skip, |query| any(query, rays, to));
                    },
                )
            }

            /// Stores in `out` whether each segment hits nothing between its ends. The ends are
            /// passed in place of origins and directions; `bits` is the number of bits after the
            /// leading bit to which they were rounded.
            fn visible(
                &self,
                py: Python<'_>,
                segments: Arrays<'_, $scalar>,
                threads: Threads,
                width: usize,
                bits: u32,
                mut out: PyReadwriteArray1<'_, bool>,
            ) -> PyResult<()> {
                let (segments, out) = (segments.source()?, out.as_slice_mut()?);
                if out.len() != segments.count {
                    return Err(PyValueError::new_err("out has the wrong length"));
                }
                let (workers, mesh) = (small_or(threads, &segments)?, self.mesh.get(py)?);
                answers(py, &workers, &segments, width, (out, false), |rays, skip, visible| {
                    let ends = |ray: &RayOf<$scalar>| [ray.origin, ray.dir];
                    let segments: Vec<_> = rays.iter().map(ends).collect();
                    without(mesh.solid.bvh(), Mode::exact(), skip, |query| {
                        query.visible_within(&segments, bits.min(52), visible);
                    });
                })
            }

            /// Fills `out` with rays that start at hits and never hit the triangles on which they
            /// start.
            #[staticmethod]
            fn spawn_rays(
                py: Python<'_>,
                vertices: PyReadonlyArray1<'_, $scalar>,
                faces: PyReadonlyArray1<'_, u32>,
                hits: PyReadonlyArray1<'_, u8>,
                directions: PyReadonlyArray1<'_, $scalar>,
                threads: Threads,
                mut out: PyReadwriteArray1<'_, $scalar>,
            ) -> PyResult<()> {
                let hits: &[Hit] = bytemuck::try_cast_slice(hits.as_slice()?).map_err(wrong)?;
                let (mesh, out) = ((vertices.as_slice()?, faces.as_slice()?), out.as_slice_mut()?);
                let workers = Workers::new(threads, hits.len() <= SMALL)?;
                spawn_rays(py, &workers, mesh, (hits, directions.as_slice()?), out)
            }

            /// Returns all hits of each ray.
            fn all<'py>(
                &self,
                py: Python<'py>,
                rays: Arrays<'py, $scalar>,
                mode: &str,
                threads: Threads,
                width: usize,
                limit: Option<usize>,
            ) -> PyResult<Lists<'py>> {
                let (mode, rays) = (named::<$scalar>(mode)?, rays.source()?);
                let mesh = self.mesh.get(py)?;
                lists(py, &small_or(threads, &rays)?, &rays, width, |rays, skip| {
                    without(mesh.solid.bvh(), mode, skip, |query| all(query, rays, limit))
                })
            }

            /// Returns all crossings of each ray.
            fn crossings<'py>(
                &self,
                py: Python<'py>,
                rays: Arrays<'py, $scalar>,
                threads: Threads,
                width: usize,
            ) -> PyResult<Lists<'py>> {
                let rays = rays.source()?;
                let mesh = self.mesh.get(py)?;
                lists(py, &small_or(threads, &rays)?, &rays, width, |rays, skip| {
                    mesh.crossings(rays, skip)
                })
            }

            /// Fills `out` with the signed and unsigned numbers of crossings of each ray.
            fn count_crossings(
                &self,
                py: Python<'_>,
                rays: Arrays<'_, $scalar>,
                threads: Threads,
                width: usize,
                mut out: Bytes<'_>,
            ) -> PyResult<()> {
                let rays = rays.source()?;
                let out: &mut [[i64; 2]] = rows(&mut out, rays.count)?;
                let mesh = self.mesh.get(py)?;
                answers(
                    py,
                    &small_or(threads, &rays)?,
                    &rays,
                    width,
                    (out, [0; 2]),
                    |rays, skip, out| {
                        let mut counts = vec![Crossings::default(); rays.len()];
                        without(mesh.solid.bvh(), Mode::exact(), skip, |query| {
                            query.count_crossings_batch_into(rays, &mut counts);
                        });
                        for (out, count) in out.iter_mut().zip(counts) {
                            *out = [count.signed, count.unsigned as i64];
                        }
                    },
                )
            }

            /// Fills `out` with 1 for points inside the mesh or on it, and 0 for all others.
            fn contains(
                &self,
                py: Python<'_>,
                points: PyReadonlyArray1<'_, $scalar>,
                assume_closed: bool,
                threads: Threads,
                mut out: Bytes<'_>,
            ) -> PyResult<()> {
                let (mesh, at) = (self.mesh.get(py)?, (&points, &mut out));
                let (ask, meaning) = (Solid::contains_batch_into, |&one: &bool| u8::from(one));
                of_solid(py, (&mesh, assume_closed), threads, at, false, ask, meaning)
            }

            /// Fills `out` with the integer winding numbers of points, or `SURFACE` on the mesh.
            fn winding(
                &self,
                py: Python<'_>,
                points: PyReadonlyArray1<'_, $scalar>,
                assume_closed: bool,
                threads: Threads,
                mut out: Bytes<'_>,
            ) -> PyResult<()> {
                let (mesh, at) = (self.mesh.get(py)?, (&points, &mut out));
                let (ask, meaning) = (Solid::classify_batch_into, |&one: &_| winding(one));
                of_solid(
                    py,
                    (&mesh, assume_closed),
                    threads,
                    at,
                    Containment::Outside,
                    ask,
                    meaning,
                )
            }

            /// Fills `out` with the winding numbers of points, or NaN on the mesh.
            fn winding_number(
                &self,
                py: Python<'_>,
                points: PyReadonlyArray1<'_, $scalar>,
                threads: Threads,
                mut out: Bytes<'_>,
            ) -> PyResult<()> {
                let (mesh, at) = (self.mesh.get(py)?, (&points, &mut out));
                let (ask, meaning) = (Solid::winding_number_batch_into, |&one: &Option<f64>| {
                    one.unwrap_or(f64::NAN)
                });
                of_solid(py, (&mesh, false), threads, at, None, ask, meaning)
            }

            /// Stores in `out` whether each point of the grid is outside, inside, or on the mesh.
            fn voxels(
                &self,
                py: Python<'_>,
                axes: [PyReadonlyArray1<'_, $scalar>; 3],
                assume_closed: bool,
                threads: Threads,
                mut out: Bytes<'_>,
            ) -> PyResult<()> {
                let [x, y, z] = axes.each_ref().map(|axis| axis.as_slice());
                let (axes, out) = ([x?, y?, z?], out.as_slice_mut()?);
                let mesh = self.mesh.get(py)?;
                let workers = Workers::new(threads, out.len() < FEW)?;
                run(py, &workers, |_| grid(mesh.solid(assume_closed)?, axes, out))?
            }

            /// Fills `out` with the closest points on the mesh.
            fn closest_point(
                &self,
                py: Python<'_>,
                points: PyReadonlyArray1<'_, $scalar>,
                radius: f64,
                threads: Threads,
                mut out: Bytes<'_>,
            ) -> PyResult<()> {
                let points = points.as_slice()?;
                let out: &mut [ClosestPoint] = rows(&mut out, points.len() / 3)?;
                let (mesh, none) = (self.mesh.get(py)?, ClosestPoint::NONE);
                of_points(
                    py,
                    &Workers::new(threads, points.len() < FEW)?,
                    points,
                    (out, none),
                    |points, out| {
                        mesh.solid.bvh().closest_point_batch_into(points, radius, out);
                    },
                )
            }

            /// Fills `out` with the distances of points, negative inside.
            fn signed_distance(
                &self,
                py: Python<'_>,
                points: PyReadonlyArray1<'_, $scalar>,
                assume_closed: bool,
                threads: Threads,
                mut out: Bytes<'_>,
            ) -> PyResult<()> {
                let points = points.as_slice()?;
                let out: &mut [f64] = rows(&mut out, points.len() / 3)?;
                let mesh = self.mesh.get(py)?;
                let workers = Workers::new(threads, points.len() < FEW)?;
                let solid = run(py, &workers, |_| mesh.solid(assume_closed))??;
                of_points(py, &workers, points, (out, 0.0), |points, out| {
                    solid.signed_distance_batch_into(points, out);
                })
            }

            /// Moves the triangles and returns the estimated slowdown of rays compared with a new
            /// tree, as a factor.
            fn refit(
                &self,
                py: Python<'_>,
                vertices: PyReadonlyArray1<'_, $scalar>,
                faces: PyReadonlyArray1<'_, u32>,
                threads: Threads,
            ) -> PyResult<f64> {
                let (vertices, faces) = (vertices.as_slice()?, faces.as_slice()?);
                let workers = Workers::new(threads, faces.len() < 3 * SMALL)?;
                self.mesh.refit(py, &workers, |stop| gather::<$scalar>(vertices, faces, stop))
            }

            /// Saves the hierarchy as bytes.
            fn to_bytes<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyBytes>> {
                let mesh = self.mesh.get(py)?;
                let bvh = mesh.solid.bvh();
                let workers = Workers::new(None, bvh.len() < SMALL)?;
                let bytes = run(py, &workers, |_| bvh.try_to_bytes())?.map_err(no_memory)?;
                PyBytes::new_with(py, bytes.len(), |to| {
                    to.copy_from_slice(&bytes);
                    Ok(())
                })
            }

            /// Loads a hierarchy over `triangles` triangles from saved bytes.
            #[staticmethod]
            fn from_bytes(py: Python<'_>, bytes: &[u8], triangles: usize) -> PyResult<Self> {
                let read = |_: &_| Mesh::from_bytes(bytes, triangles);
                let mesh = run(py, &Workers::new(None, triangles < SMALL)?, read)??;
                Ok(Self { mesh: Shared::new(mesh) })
            }

            /// Measures how many seconds the call in Rust takes to find the closest hits of these
            /// rays, in the given order and in the tile order of a square image. This is for
            /// benchmarks.
            fn seconds(
                &self,
                py: Python<'_>,
                rays: Arrays<'_, $scalar>,
                threads: Threads,
                times: usize,
            ) -> PyResult<(f64, f64)> {
                let rays = rays.source()?;
                let mesh = self.mesh.get(py)?;
                let mut in_rows = Vec::new();
                let in_rows = rays.rays(0..rays.count, &mut in_rows).to_vec();
                let by_tiles = tiled(&rays);
                let mut hits = vec![Hit::MISS; rays.count];
                run(py, &Workers::new(threads, false)?, |_| {
                    let (mut a, mut b) = (f64::INFINITY, f64::INFINITY);
                    for _ in 0..times {
                        for (rays, least) in [(&in_rows, &mut a), (&by_tiles, &mut b)] {
                            let began = Instant::now();
                            closest(&mut mesh.solid.bvh().query(), rays, &mut hits);
                            *least = least.min(began.elapsed().as_secs_f64());
                        }
                    }
                    (a, b)
                })
            }
        }
    };
}

tree!(Tree32, f32);
tree!(Tree64, f64);
