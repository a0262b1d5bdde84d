//! Where rays come from: numpy arrays of origins and directions, or of whole rays.

use std::ops::Range;

use intertri::RayOf;
use numpy::{Element, PyReadonlyArray1};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;

use crate::scalar::Scalar;

/// Borrowed arrays of rays, flat and contiguous: `origins` holds 3 numbers a ray, or 3 for all, and so does
/// `directions`; `t_min` and `t_max` 1 a ray, or 1 for all. Without `directions`, `origins` holds whole rays of
/// 6 or 8 numbers.
#[derive(FromPyObject)]
pub(crate) struct Arrays<'py, S: Element> {
    count: usize,
    columns: usize,
    origins: PyReadonlyArray1<'py, S>,
    directions: Option<PyReadonlyArray1<'py, S>>,
    t_min: PyReadonlyArray1<'py, S>,
    t_max: PyReadonlyArray1<'py, S>,
}

/// A row a ray, or one for all.
#[derive(Clone, Copy)]
struct Rows<'a, T> {
    rows: &'a [T],
    step: usize,
}

impl<'a, T: Copy> Rows<'a, T> {
    fn new(rows: &'a [T], count: usize) -> PyResult<Self> {
        match rows.len() {
            length if length == count => Ok(Self { rows, step: 1 }),
            1 => Ok(Self { rows, step: 0 }),
            _ => Err(PyValueError::new_err("the arrays of rays differ in length")),
        }
    }

    #[inline]
    fn at(&self, ray: usize) -> T {
        self.rows[ray * self.step]
    }
}

/// The rays of borrowed arrays.
pub(crate) struct Source<'a, S> {
    pub(crate) count: usize,
    layout: Layout<'a, S>,
}

enum Layout<'a, S> {
    Three { origins: Rows<'a, [S; 3]>, dirs: Rows<'a, [S; 3]>, ends: Ends<'a, S> },
    Six { rays: Rows<'a, [S; 6]>, ends: Ends<'a, S> },
    Eight { rays: Rows<'a, [S; 8]> },
}

/// From which t to which.
#[derive(Clone, Copy)]
struct Ends<'a, S> {
    t_min: Rows<'a, S>,
    t_max: Rows<'a, S>,
}

impl<S: Scalar> Arrays<'_, S> {
    /// The rays in them.
    pub(crate) fn source(&self) -> PyResult<Source<'_, S>> {
        let count = self.count;
        let ends = Ends {
            t_min: Rows::new(self.t_min.as_slice()?, count)?,
            t_max: Rows::new(self.t_max.as_slice()?, count)?,
        };
        let first = self.origins.as_slice()?;
        let layout = match (&self.directions, self.columns) {
            (Some(dirs), 3) => Layout::Three {
                origins: Rows::new(first.as_chunks().0, count)?,
                dirs: Rows::new(dirs.as_slice()?.as_chunks().0, count)?,
                ends,
            },
            (None, 6) => Layout::Six { rays: Rows::new(first.as_chunks().0, count)?, ends },
            (None, 8) => Layout::Eight { rays: Rows::new(first.as_chunks().0, count)? },
            _ => return Err(PyValueError::new_err("rays have 3, 6 or 8 columns")),
        };
        Ok(Source { count, layout })
    }
}

impl<S: Scalar> Source<'_, S> {
    /// Where a ray starts, and where it goes.
    pub(crate) fn line(&self, i: usize) -> [[f64; 3]; 2] {
        let (origin, dir) = match &self.layout {
            Layout::Three { origins, dirs, .. } => (origins.at(i), dirs.at(i)),
            Layout::Six { rays, .. } => {
                let [x, y, z, dx, dy, dz] = rays.at(i);
                ([x, y, z], [dx, dy, dz])
            }
            Layout::Eight { rays } => {
                let [x, y, z, _, dx, dy, dz, _] = rays.at(i);
                ([x, y, z], [dx, dy, dz])
            }
        };
        [origin.map(Into::into), dir.map(Into::into)]
    }

    /// Gathers some rays, by their numbers.
    #[inline]
    pub(crate) fn gather(
        &self,
        numbers: impl ExactSizeIterator<Item = usize>,
        to: &mut Vec<RayOf<S>>,
    ) {
        to.clear();
        match &self.layout {
            Layout::Three { origins, dirs, ends: Ends { t_min, t_max } } => {
                to.extend(
                    numbers.map(|i| ray(origins.at(i), dirs.at(i), t_min.at(i), t_max.at(i))),
                );
            }
            Layout::Six { rays, ends: Ends { t_min, t_max } } => to.extend(numbers.map(|i| {
                let [x, y, z, dx, dy, dz] = rays.at(i);
                ray([x, y, z], [dx, dy, dz], t_min.at(i), t_max.at(i))
            })),
            Layout::Eight { rays } => to.extend(numbers.map(|i| {
                let [x, y, z, t_min, dx, dy, dz, t_max] = rays.at(i);
                ray([x, y, z], [dx, dy, dz], t_min, t_max)
            })),
        }
    }

    /// The rays of a range: those of the array itself where it holds whole rays, else gathered.
    pub(crate) fn rays<'s>(
        &'s self,
        range: Range<usize>,
        gathered: &'s mut Vec<RayOf<S>>,
    ) -> &'s [RayOf<S>] {
        if let Layout::Eight { rays } = &self.layout
            && rays.step == 1
            && let Ok(rays) = bytemuck::try_cast_slice(rays.rows[range.clone()].as_flattened())
        {
            return rays;
        }
        self.gather(range, gathered);
        gathered
    }
}

#[inline]
fn ray<S>(origin: [S; 3], dir: [S; 3], t_min: S, t_max: S) -> RayOf<S> {
    RayOf { origin, t_min, dir, t_max }
}
