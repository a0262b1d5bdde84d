//! Sources of rays: numpy arrays of origins and directions, or of whole rays.

use std::ops::Range;

use intertri::RayOf;
use intertri::simd::prefetch_early;
use numpy::{Element, PyReadonlyArray1};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;

use crate::scalar::Scalar;
use crate::skip::Skip;

/// Borrowed arrays of rays, flat and contiguous. `origins` and `directions` contain 3 values per
/// ray, or 3 for all rays; `t_min` and `t_max` contain 1 value per ray, or 1 for all rays. If
/// `directions` is missing, `origins` contains whole rays of 6 or 8 values.
#[derive(FromPyObject)]
pub(crate) struct Arrays<'py, S: Element> {
    count: usize,
    columns: usize,
    origins: PyReadonlyArray1<'py, S>,
    directions: Option<PyReadonlyArray1<'py, S>>,
    t_min: PyReadonlyArray1<'py, S>,
    t_max: PyReadonlyArray1<'py, S>,
    skip: Option<PyReadonlyArray1<'py, i32>>,
}

/// One row per ray, or a single row for all rays, of which four copies are stored.
struct Rows<'a, T> {
    rows: &'a [T],
    one: Option<[T; 4]>,
}

impl<'a, T: Copy> Rows<'a, T> {
    fn new(rows: &'a [T], count: usize) -> PyResult<Self> {
        match rows {
            _ if rows.len() == count => Ok(Self { rows, one: None }),
            &[one] => Ok(Self { rows, one: Some([one; 4]) }),
            _ => Err(PyValueError::new_err("the arrays of rays differ in length")),
        }
    }

    #[inline]
    fn at(&self, ray: usize) -> T {
        self.one.map_or_else(|| self.rows[ray], |[one, ..]| one)
    }

    /// Returns the rows of four rays.
    #[inline]
    fn four(&self, first: usize) -> &[T; 4] {
        match (&self.one, self.rows.get(first..).and_then(|rows| rows.first_chunk())) {
            (Some(one), _) => one,
            (None, Some(four)) => four,
            (None, None) => unreachable!("there are fewer than four rays"),
        }
    }

    fn prefetch(&self, rays: Range<usize>) {
        if self.one.is_none() {
            prefetch_early(&self.rows[rays]);
        }
    }
}

/// The rays that borrowed arrays describe.
pub(crate) struct Source<'a, S> {
    pub(crate) count: usize,
    layout: Layout<'a, S>,
    skip: Skip<'a>,
}

enum Layout<'a, S> {
    Three { origins: Rows<'a, [S; 3]>, dirs: Rows<'a, [S; 3]>, ends: Ends<'a, S> },
    Six { rays: Rows<'a, [S; 6]>, ends: Ends<'a, S> },
    Eight { rays: Rows<'a, [S; 8]> },
}

/// The limits of the rays' intervals of t.
struct Ends<'a, S> {
    t_min: Rows<'a, S>,
    t_max: Rows<'a, S>,
}

impl<S: Scalar> Ends<'_, S> {
    /// Writes four rays, calling `line` for their origins and directions.
    #[inline]
    fn put(&self, first: usize, to: &mut [RayOf<S>], line: impl Fn(usize) -> ([S; 3], [S; 3])) {
        let (t_min, t_max) = (self.t_min.four(first), self.t_max.four(first));
        for (k, to) in to.iter_mut().enumerate().take(4) {
            *to = ray(line(k), t_min[k], t_max[k]);
        }
    }
}

impl<S: Scalar> Arrays<'_, S> {
    /// Returns the rays that the arrays describe.
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
            _ => return Err(PyValueError::new_err("rays have 3, 6, or 8 columns")),
        };
        let numbers = self.skip.as_ref().map_or(Ok(&[][..]), |skip| skip.as_slice())?;
        let each = numbers.len() / count.max(1);
        if numbers.len() != each * count {
            return Err(PyValueError::new_err("skip has the wrong length"));
        }
        Ok(Source { count, layout, skip: Skip { numbers, each } })
    }
}

impl<S: Scalar> Source<'_, S> {
    /// Returns the origin and the direction of a ray.
    pub(crate) fn line(&self, i: usize) -> [[f64; 3]; 2] {
        let RayOf { origin, dir, .. } = self.ray(i);
        [origin.map(Into::into), dir.map(Into::into)]
    }

    /// Returns whether rays skip triangles.
    pub(crate) fn skips(&self) -> bool {
        self.skip.each > 0
    }

    /// Returns the triangles that the rays of a range skip.
    pub(crate) fn skip(&self, range: Range<usize>) -> Skip<'_> {
        let Skip { numbers, each } = self.skip;
        Skip { numbers: &numbers[each * range.start..each * range.end], each }
    }

    /// Writes `count` rays, beginning with the ray `first`, in groups of four. `begins` yields the
    /// index in `to` where each group begins.
    #[inline]
    pub(crate) fn put(
        &self,
        (first, count): (usize, usize),
        mut begins: impl Iterator<Item = usize>,
        to: &mut [RayOf<S>],
    ) {
        let fours = (first..first + count / 4 * 4).step_by(4);
        for (i, begin) in fours.zip(&mut begins) {
            let to = &mut to[begin..begin + 4];
            match &self.layout {
                Layout::Three { origins, dirs, ends } => {
                    let (origins, dirs) = (origins.four(i), dirs.four(i));
                    ends.put(i, to, |k| (origins[k], dirs[k]));
                }
                Layout::Six { rays, ends } => {
                    let rays = rays.four(i);
                    ends.put(i, to, |k| line(rays[k]));
                }
                Layout::Eight { rays } => {
                    to.iter_mut().zip(rays.four(i)).for_each(|(to, &ray)| *to = whole(ray));
                }
            }
        }
        if let Some(begin) = begins.next() {
            let rest = (first + count / 4 * 4..first + count).map(|i| self.ray(i));
            to[begin..].iter_mut().zip(rest).for_each(|(to, ray)| *to = ray);
        }
    }

    fn ray(&self, i: usize) -> RayOf<S> {
        match &self.layout {
            Layout::Three { origins, dirs, ends: Ends { t_min, t_max } } => {
                ray((origins.at(i), dirs.at(i)), t_min.at(i), t_max.at(i))
            }
            Layout::Six { rays, ends: Ends { t_min, t_max } } => {
                ray(line(rays.at(i)), t_min.at(i), t_max.at(i))
            }
            Layout::Eight { rays } => whole(rays.at(i)),
        }
    }

    /// Prefetches the rays of a range.
    pub(crate) fn prefetch(&self, range: Range<usize>) {
        match &self.layout {
            Layout::Three { origins, dirs, .. } => {
                origins.prefetch(range.clone());
                dirs.prefetch(range);
            }
            Layout::Six { rays, .. } => rays.prefetch(range),
            // Do not prefetch for this layout: rows whose size is a power of two share cache sets,
            // which makes prefetching slower.
            Layout::Eight { .. } => {}
        }
    }

    /// Returns the rays of a range, borrowed if the array contains whole rays and gathered
    /// otherwise.
    pub(crate) fn rays<'s>(
        &'s self,
        range: Range<usize>,
        gathered: &'s mut Vec<RayOf<S>>,
    ) -> &'s [RayOf<S>] {
        if let Layout::Eight { rays } = &self.layout
            && rays.one.is_none()
            && let Ok(rays) = bytemuck::try_cast_slice(rays.rows[range.clone()].as_flattened())
        {
            return rays;
        }
        gathered.resize(range.len(), RayOf::new([S::default(); 3], [S::default(); 3]));
        self.put((range.start, range.len()), (0..).step_by(4), gathered);
        gathered
    }
}

#[inline]
fn ray<S>((origin, dir): ([S; 3], [S; 3]), t_min: S, t_max: S) -> RayOf<S> {
    RayOf { origin, t_min, dir, t_max }
}

#[inline]
fn line<S>([x, y, z, dx, dy, dz]: [S; 6]) -> ([S; 3], [S; 3]) {
    ([x, y, z], [dx, dy, dz])
}

#[inline]
fn whole<S>([x, y, z, t_min, dx, dy, dz, t_max]: [S; 8]) -> RayOf<S> {
    ray(([x, y, z], [dx, dy, dz]), t_min, t_max)
}
