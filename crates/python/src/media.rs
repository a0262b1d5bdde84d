//! The classes behind Python's `Media`.

use bytemuck::{Pod, Zeroable};
use intertri::{Hit, TriangleOf};
use intertri_trace::internal::on_this_thread;
use intertri_trace::{Media, MediaError, MediumCrossing, Segment, SolidError};
use numpy::PyReadonlyArray1;
use pyo3::prelude::*;

use crate::batch::answers;
use crate::lists::{Lists, lists};
use crate::output::{Bytes, FEW, SMALL, Threads, rows};
use crate::part::Part;
use crate::points::of_points;
use crate::pool::Workers;
use crate::run::run;
use crate::scalar::{Scalar, no_memory, wrong};
use crate::source::Arrays;
use crate::tree::{gather, small_or};

/// The medium number for points outside all media.
const OUTSIDE: i32 = -1;

/// The vertices and faces of a mesh.
type Arrays32<'py, S> = (PyReadonlyArray1<'py, S>, PyReadonlyArray1<'py, u32>);

/// A segment, as a row of a numpy array.
#[derive(Clone, Copy, Pod, Zeroable)]
#[repr(C)]
struct SegmentRow {
    start: f64,
    end: f64,
    u: f64,
    v: f64,
    triangle: u32,
    geometry: u32,
    medium: i32,
    padding: u32,
}

/// A crossing into another medium, as a row of a numpy array.
#[derive(Clone, Copy, Pod, Zeroable)]
#[repr(C)]
struct CrossingRow {
    hit: Hit,
    left: i32,
    entered: i32,
}

impl CrossingRow {
    const NONE: Self = Self { hit: Hit::MISS, left: OUTSIDE, entered: OUTSIDE };

    fn new(crossing: Option<MediumCrossing>) -> Self {
        crossing.map_or(Self::NONE, |MediumCrossing { hit, left, entered }| Self {
            hit,
            left: number(left),
            entered: number(entered),
        })
    }
}

impl SegmentRow {
    fn new(&Segment { start, end, medium, wall }: &Segment) -> Self {
        let Hit { u, v, triangle, geometry, .. } = wall;
        Self { start, end, u, v, triangle, geometry, medium: number(medium), padding: 0 }
    }
}

/// Returns the number of a medium, or `OUTSIDE` for `None`.
fn number(medium: Option<u32>) -> i32 {
    medium.map_or(OUTSIDE, |medium| medium as i32)
}

/// Builds the media, given the meshes and the number of the medium that fills each mesh.
fn media<S: Scalar>(meshes: &[Vec<TriangleOf<S>>], filled: &[u32]) -> PyResult<Media<S>> {
    let meshes: Vec<_> = filled.iter().copied().zip(meshes.iter().map(Vec::as_slice)).collect();
    Media::new(&meshes).map_err(|error| match error {
        MediaError::Build(error) | MediaError::Mesh { error: SolidError::Build(error), .. } => {
            no_memory(error)
        }
        error => wrong(error),
    })
}

/// Defines a class for one scalar type, because a generic type cannot be a Python class.
macro_rules! media_class {
    ($name:ident, $scalar:ty) => {
        /// Closed meshes, each filled with a medium.
        #[pyclass(frozen, module = "intertri._intertri")]
        pub(crate) struct $name {
            media: Media<$scalar>,
        }

        #[pymethods]
        impl $name {
            #[new]
            fn new(
                py: Python<'_>,
                meshes: Vec<Arrays32<'_, $scalar>>,
                filled: Vec<u32>,
                threads: Threads,
            ) -> PyResult<Self> {
                let slices = meshes
                    .iter()
                    .map(|(vertices, faces)| Ok((vertices.as_slice()?, faces.as_slice()?)));
                let slices: Vec<_> = slices.collect::<PyResult<_>>()?;
                let count: usize = slices.iter().map(|(_, faces)| faces.len()).sum();
                let media = run(py, &Workers::new(threads, count < 3 * SMALL)?, |stop| {
                    let meshes =
                        slices.iter().map(|(vertices, faces)| gather(vertices, faces, stop));
                    media(&meshes.collect::<PyResult<Vec<_>>>()?, &filled)
                })??;
                Ok(Self { media })
            }

            /// Fills `out` with the media at points, or -1 for outside.
            fn medium_at(
                &self,
                py: Python<'_>,
                points: PyReadonlyArray1<'_, $scalar>,
                threads: Threads,
                mut out: Bytes<'_>,
            ) -> PyResult<()> {
                let points = points.as_slice()?;
                let out: &mut [i32] = rows(&mut out, points.len() / 3)?;
                let workers = Workers::new(threads, points.len() < FEW)?;
                of_points(py, &workers, points, (out, OUTSIDE), |points, out| {
                    // If there is not enough memory for a list of answers, answer the points one by
                    // one.
                    match on_this_thread(|| self.media.medium_at_batch(points)) {
                        Ok(found) => {
                            out.iter_mut()
                                .zip(found)
                                .for_each(|(out, medium)| *out = number(medium));
                        }
                        Err(_) => out
                            .iter_mut()
                            .zip(points)
                            .for_each(|(out, point)| *out = number(self.media.medium_at(*point))),
                    }
                })
            }

            /// Fills `out` with the next crossing of each ray into another medium.
            fn next_crossing(
                &self,
                py: Python<'_>,
                rays: Arrays<'_, $scalar>,
                threads: Threads,
                width: usize,
                mut out: Bytes<'_>,
            ) -> PyResult<()> {
                let rays = rays.source()?;
                let out: &mut [CrossingRow] = rows(&mut out, rays.count)?;
                let workers = small_or(threads, &rays)?;
                answers(py, &workers, &rays, width, (out, CrossingRow::NONE), |rays, _, out| {
                    match on_this_thread(|| self.media.next_crossing_batch(rays)) {
                        Ok(found) => out
                            .iter_mut()
                            .zip(found)
                            .for_each(|(out, crossing)| *out = CrossingRow::new(crossing)),
                        Err(_) => out.iter_mut().zip(rays).for_each(|(out, ray)| {
                            *out = CrossingRow::new(self.media.next_crossing(ray));
                        }),
                    }
                })
            }

            /// Returns the segments of each ray.
            fn segments<'py>(
                &self,
                py: Python<'py>,
                rays: Arrays<'py, $scalar>,
                threads: Threads,
                width: usize,
            ) -> PyResult<Lists<'py>> {
                let rays = rays.source()?;
                lists(py, &small_or(threads, &rays)?, &rays, width, |rays, _| {
                    let lists = on_this_thread(|| self.media.segments_batch(rays));
                    let lists = lists.map_err(no_memory)?;
                    let mut answers = Vec::new();
                    answers.try_reserve_exact(lists.items.len()).map_err(no_memory)?;
                    answers.extend(lists.items.iter().map(SegmentRow::new));
                    Ok(Part { offsets: lists.offsets, answers })
                })
            }
        }
    };
}

media_class!(Media32, f32);
media_class!(Media64, f64);
