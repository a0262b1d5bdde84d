//! The scalars that coordinates come in, and what is asked in a mode that Python names.

use intertri::{Certified, Exact, Hit, RayOf};
use intertri_trace::{Given, Only};
use numpy::Element;
use pyo3::exceptions::{PyMemoryError, PyValueError};
use pyo3::{PyErr, PyResult};

use crate::part::Part;

/// What answers promise.
#[derive(Clone, Copy)]
pub(crate) enum Mode {
    Exact,
    Certified,
}

impl Mode {
    /// The mode of a name, if coordinates in a scalar have it.
    pub(crate) fn named<S: Scalar>(name: &str) -> PyResult<Self> {
        match name {
            "exact" => Ok(Self::Exact),
            "certified" if S::has(Self::Certified) => Ok(Self::Certified),
            "certified" => Err(PyValueError::new_err(
                "mode 'certified' answers for float32 vertices and rays, and these are float64",
            )),
            _ => Err(PyValueError::new_err(format!(
                "mode {name:?} is neither 'exact' nor 'certified'"
            ))),
        }
    }
}

/// f32 or f64.
pub(crate) trait Scalar: Element + Given {
    /// Whether a mode answers.
    fn has(mode: Mode) -> bool;
    fn closest(bvh: &Only<'_, Self>, mode: Mode, rays: &[RayOf<Self>], hits: &mut [Hit]);
    fn triangles(bvh: &Only<'_, Self>, mode: Mode, rays: &[RayOf<Self>], triangles: &mut [u32]);
    fn any(bvh: &Only<'_, Self>, mode: Mode, rays: &[RayOf<Self>], any: &mut [bool]);
    fn all(
        bvh: &Only<'_, Self>,
        mode: Mode,
        rays: &[RayOf<Self>],
        limit: Option<usize>,
    ) -> PyResult<Part<Hit>>;
}

/// The queries of a scalar: `$by_mode` says which modes there are.
macro_rules! queries {
    ($by_mode:ident) => {
        fn closest(bvh: &Only<'_, Self>, mode: Mode, rays: &[RayOf<Self>], hits: &mut [Hit]) {
            // A ray alone needs nothing of what a batch prepares.
            if let ([ray], [to]) = (rays, &mut *hits) {
                *to = $by_mode!(mode, mode => bvh.closest(mode, ray)).unwrap_or(Hit::MISS);
            } else {
                $by_mode!(mode, mode => bvh.closest_batch(mode, rays, hits));
            }
        }

        fn triangles(bvh: &Only<'_, Self>, mode: Mode, rays: &[RayOf<Self>], triangles: &mut [u32]) {
            if let ([ray], [to]) = (rays, &mut *triangles) {
                let hit = $by_mode!(mode, mode => bvh.closest(mode, ray));
                *to = hit.map_or(Hit::NO_TRIANGLE, |hit| hit.triangle);
            } else {
                $by_mode!(mode, mode => bvh.triangles_batch(mode, rays, triangles));
            }
        }

        fn any(bvh: &Only<'_, Self>, mode: Mode, rays: &[RayOf<Self>], any: &mut [bool]) {
            if let ([ray], [to]) = (rays, &mut *any) {
                *to = $by_mode!(mode, mode => bvh.any(mode, ray));
            } else {
                $by_mode!(mode, mode => bvh.any_batch(mode, rays, any));
            }
        }

        fn all(
            bvh: &Only<'_, Self>,
            mode: Mode,
            rays: &[RayOf<Self>],
            limit: Option<usize>,
        ) -> PyResult<Part<Hit>> {
            let lists = $by_mode!(mode, mode => bvh.all_batch(mode, rays, limit));
            let lists = lists.map_err(no_memory)?;
            Ok(Part { offsets: lists.offsets, answers: lists.hits })
        }
    };
}

pub(crate) fn no_memory(error: impl ToString) -> PyErr {
    PyMemoryError::new_err(error.to_string())
}

pub(crate) fn wrong(error: impl ToString) -> PyErr {
    PyValueError::new_err(error.to_string())
}

/// Either mode.
macro_rules! either {
    ($mode:expr, $name:ident => $ask:expr) => {
        match $mode {
            Mode::Exact => {
                let $name = &Exact::default();
                $ask
            }
            Mode::Certified => {
                let $name = &Certified::default();
                $ask
            }
        }
    };
}

/// The mode exact, whatever the name.
macro_rules! exact_alone {
    ($mode:expr, $name:ident => $ask:expr) => {{
        let (Mode::Exact | Mode::Certified) = $mode;
        let $name = &Exact::default();
        $ask
    }};
}

impl Scalar for f32 {
    queries!(either);

    fn has(_: Mode) -> bool {
        true
    }
}

impl Scalar for f64 {
    queries!(exact_alone);

    fn has(mode: Mode) -> bool {
        matches!(mode, Mode::Exact)
    }
}
