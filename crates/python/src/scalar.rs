//! The scalars that coordinates come in, and what is asked of a mesh of either.

use intertri::internal::exact::{self, Side};
use intertri::{Certified, Crossings, Exact, Hit, RayOf, TriangleOf};
use intertri_trace::{Bvh, ClosestPoint, Given, Place, Solid};
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

/// f32 or f64. A mesh with its hierarchy is a `Solid` of them, closed or not.
pub(crate) trait Scalar: Element + Given {
    fn solid(triangles: &[TriangleOf<Self>]) -> PyResult<Solid<Self>>;
    /// Moves the triangles, and tells how worn the tree is: 1 where nothing has moved.
    fn refit(mesh: &mut Solid<Self>, triangles: &[TriangleOf<Self>]) -> PyResult<f64>;
    /// The hierarchy as bytes, none where it cannot be saved; and back.
    fn to_bytes(mesh: &Solid<Self>) -> Vec<u8>;
    fn from_bytes(bytes: &[u8], triangles: &[TriangleOf<Self>]) -> PyResult<Solid<Self>>;
    /// Which edge of a mesh is open, and how.
    fn open_edge(triangles: &[TriangleOf<Self>]) -> Option<String>;

    /// Whether a mode answers.
    fn has(mode: Mode) -> bool;
    fn closest(mesh: &Solid<Self>, mode: Mode, rays: &[RayOf<Self>], hits: &mut [Hit]);
    fn triangles(mesh: &Solid<Self>, mode: Mode, rays: &[RayOf<Self>], triangles: &mut [u32]);
    fn any(mesh: &Solid<Self>, mode: Mode, rays: &[RayOf<Self>], any: &mut [bool]);
    fn all(
        mesh: &Solid<Self>,
        mode: Mode,
        rays: &[RayOf<Self>],
        limit: Option<usize>,
    ) -> PyResult<Part<Hit>>;
    /// The triangles, in the order in which they were given.
    fn all_triangles(mesh: &Solid<Self>) -> Vec<TriangleOf<Self>>;
    /// Whether a ray that meets a triangle crosses it, and if so, whether it leaves.
    fn crossing(ray: &RayOf<Self>, triangle: &TriangleOf<Self>) -> Option<bool>;
    fn count(mesh: &Solid<Self>, rays: &[RayOf<Self>], counts: &mut [Crossings]);

    fn places(mesh: &Solid<Self>, points: &[[Self; 3]], places: &mut [Place]);
}

/// What the queries of both scalars share: `$by_mode` says which modes there are.
macro_rules! queries {
    ($by_mode:ident) => {
        fn solid(triangles: &[TriangleOf<Self>]) -> PyResult<Solid<Self>> {
            Solid::assume_closed(triangles).map_err(no_memory)
        }

        fn open_edge(triangles: &[TriangleOf<Self>]) -> Option<String> {
            Solid::new(triangles).err().map(|error| error.to_string())
        }

        fn closest(mesh: &Solid<Self>, mode: Mode, rays: &[RayOf<Self>], hits: &mut [Hit]) {
            $by_mode!(mode, mode => mesh.bvh().closest_batch(mode, rays, hits));
        }

        fn triangles(mesh: &Solid<Self>, mode: Mode, rays: &[RayOf<Self>], triangles: &mut [u32]) {
            $by_mode!(mode, mode => mesh.bvh().triangles_batch(mode, rays, triangles));
        }

        fn any(mesh: &Solid<Self>, mode: Mode, rays: &[RayOf<Self>], any: &mut [bool]) {
            $by_mode!(mode, mode => mesh.bvh().any_batch(mode, rays, any));
        }

        fn all(
            mesh: &Solid<Self>,
            mode: Mode,
            rays: &[RayOf<Self>],
            limit: Option<usize>,
        ) -> PyResult<Part<Hit>> {
            let lists = $by_mode!(mode, mode => mesh.bvh().all_batch(mode, rays, limit));
            let lists = lists.map_err(no_memory)?;
            let counts = lists.offsets.windows(2).map(|ends| (ends[1] - ends[0]) as u32).collect();
            Ok(Part { counts, answers: lists.hits })
        }

        fn all_triangles(mesh: &Solid<Self>) -> Vec<TriangleOf<Self>> {
            mesh.bvh().to_triangles()
        }

        fn crossing(ray: &RayOf<Self>, triangle: &TriangleOf<Self>) -> Option<bool> {
            exact::crossing(ray, triangle).map(|side| side == Side::Leaves)
        }

        fn count(mesh: &Solid<Self>, rays: &[RayOf<Self>], counts: &mut [Crossings]) {
            mesh.bvh().crossings_batch(&Exact::default(), rays, counts);
        }

        fn places(mesh: &Solid<Self>, points: &[[Self; 3]], places: &mut [Place]) {
            mesh.place_batch(points, places);
        }
    };
}

fn no_memory(error: impl ToString) -> PyErr {
    PyMemoryError::new_err(error.to_string())
}

fn wrong(error: impl ToString) -> PyErr {
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

    fn refit(mesh: &mut Solid, triangles: &[TriangleOf<f32>]) -> PyResult<f64> {
        let none = Self::solid(&[])?;
        let mut bvh = std::mem::replace(mesh, none).into_bvh();
        let refit = bvh.refit(triangles);
        *mesh = Solid::assume_closed_bvh(bvh);
        refit.map(|refit| refit.ratio()).map_err(wrong)
    }

    fn to_bytes(mesh: &Solid) -> Vec<u8> {
        mesh.bvh().to_bytes()
    }

    fn from_bytes(bytes: &[u8], triangles: &[TriangleOf<f32>]) -> PyResult<Solid> {
        let bvh: Bvh = Bvh::from_bytes(bytes).map_err(wrong)?;
        if bvh.len() == triangles.len() {
            Ok(Solid::assume_closed_bvh(bvh))
        } else {
            Err(wrong(format!("a hierarchy of {} triangles, not {}", bvh.len(), triangles.len())))
        }
    }
}

/// Hierarchies over f64 are neither saved nor refitted yet: they are built anew.
impl Scalar for f64 {
    queries!(exact_alone);

    fn has(mode: Mode) -> bool {
        matches!(mode, Mode::Exact)
    }

    fn refit(mesh: &mut Solid<f64>, triangles: &[TriangleOf<f64>]) -> PyResult<f64> {
        *mesh = Self::solid(triangles)?;
        Ok(1.0)
    }

    fn to_bytes(_: &Solid<f64>) -> Vec<u8> {
        Vec::new()
    }

    fn from_bytes(bytes: &[u8], triangles: &[TriangleOf<f64>]) -> PyResult<Solid<f64>> {
        if bytes.is_empty() {
            Self::solid(triangles)
        } else {
            Err(wrong("a hierarchy of triangles in float32, not float64"))
        }
    }
}

/// The closest points of a mesh over f32.
pub(crate) fn nearest(mesh: &Solid, points: &[[f32; 3]], radius: f64, out: &mut [ClosestPoint]) {
    mesh.bvh().closest_point_batch(points, radius, out);
}
