//! Solids: what a closed mesh winds around.

mod boundary;
mod distance;

use std::fmt;

use intertri::{Exact, Scalar, TriangleOf};

use crate::build::BuildError;
use crate::bvh::Bvh;
use crate::given::{Given, ModeFor};
use crate::memory::NoMemory;
use crate::place::Place;
use boundary::open_edge;

/// A closed mesh, and the hierarchy over it: it tells inside from outside, exactly.
///
/// Closed means that every edge is run along as often one way as the other, whatever else the mesh is: it may
/// be in parts, meet itself, and have triangles twice or without area.
///
/// ```
/// use intertri_trace::{Place, Solid, intertri::Triangle};
/// let [o, x, y, z] = [[0.0; 3], [4.0, 0.0, 0.0], [0.0, 4.0, 0.0], [0.0, 0.0, 4.0]];
/// let faces = [[o, y, x], [o, x, z], [o, z, y], [x, y, z]].map(|[a, b, c]| Triangle::new(a, b, c));
/// let solid = Solid::new(&faces)?;
/// let points = [[1.0, 1.0, 1.0], [3.0, 3.0, 3.0], [1.0, 1.0, 2.0], [1.0, 1.0, 2.000_000_2]];
/// let places = points.map(|point| solid.place(point));
/// assert_eq!(places, [Place::Inside(1), Place::Outside, Place::Surface, Place::Outside]);
/// assert!(Solid::new(&faces[1..]).unwrap_err().to_string().contains("is open"));
/// # Ok::<(), intertri_trace::SolidError>(())
/// ```
#[derive(Clone, Debug)]
pub struct Solid<S: Given = f32> {
    bvh: Bvh<S>,
}

impl<S: Given> Solid<S>
where
    Exact: ModeFor<S>,
{
    /// Of a closed mesh.
    ///
    /// # Errors
    /// If it is open, something is not finite, or there is no hierarchy over it.
    pub fn new(triangles: &[TriangleOf<S>]) -> Result<Self, SolidError<S>> {
        Self::check_closed(triangles)?;
        Ok(Self::assume_closed(triangles)?)
    }

    /// What [`Solid::new`] asks of triangles, without a hierarchy: for who has one already, or needs none.
    ///
    /// # Errors
    /// If they are open, something is not finite, or there is too little memory.
    ///
    /// ```
    /// use intertri_trace::{Bvh, Solid, intertri::Triangle};
    /// let [o, x, y, z] = [[0.0; 3], [4.0, 0.0, 0.0], [0.0, 4.0, 0.0], [0.0, 0.0, 4.0]];
    /// let faces = [[o, y, x], [o, x, z], [o, z, y], [x, y, z]].map(|[a, b, c]| Triangle::new(a, b, c));
    /// let bvh = Bvh::new(&faces)?;
    /// Solid::check_closed(&faces)?;
    /// let solid = Solid::assume_closed_bvh(bvh);
    /// assert!(Solid::check_closed(&faces[1..]).is_err());
    /// # Ok::<(), intertri_trace::SolidError>(())
    /// ```
    pub fn check_closed(triangles: &[TriangleOf<S>]) -> Result<(), SolidError<S>> {
        let finite = |t: &TriangleOf<S>| t.0.as_flattened().iter().all(|x| x.is_finite());
        if let Some(triangle) = triangles.iter().position(|triangle| !finite(triangle)) {
            return Err(SolidError::NotFinite { triangle });
        }
        match open_edge(triangles) {
            Ok(Some((triangle, edge))) => Err(SolidError::Open { triangle, edge }),
            Ok(None) => Ok(()),
            Err(NoMemory) => Err(BuildError::OutOfMemory { count: triangles.len() }.into()),
        }
    }

    /// Of any mesh: of an open one the answers depend on the direction in which crossings are counted.
    ///
    /// # Errors
    /// If there is no hierarchy over it.
    pub fn assume_closed(triangles: &[TriangleOf<S>]) -> Result<Self, BuildError> {
        Ok(Self { bvh: Bvh::new(triangles)? })
    }

    /// Of a mesh over which there is a hierarchy, one that was loaded or refitted for instance, as by
    /// [`Solid::assume_closed`]. All its geometries together are the mesh, whatever their masks.
    pub fn assume_closed_bvh(bvh: Bvh<S>) -> Self {
        Self { bvh }
    }

    /// The hierarchy over the mesh, and nothing else.
    pub fn into_bvh(self) -> Bvh<S> {
        self.bvh
    }

    /// The hierarchy over the mesh.
    pub fn bvh(&self) -> &Bvh<S> {
        &self.bvh
    }

    /// Where a point lies. One that is not finite is outside.
    pub fn place(&self, point: [S; 3]) -> Place {
        self.bvh.place(Exact::default(), point)
    }

    /// [`Solid::place`] of many points: `places[i]` becomes that of `points[i]`.
    ///
    /// # Panics
    /// If the slices differ in length.
    pub fn place_batch(&self, points: &[[S; 3]], places: &mut [Place]) {
        self.bvh.places(Exact::default(), points, places, |place| place);
    }

    /// Whether points are inside or on the surface: `contains[i]` becomes the answer for `points[i]`.
    ///
    /// # Panics
    /// If the slices differ in length.
    pub fn contains_batch(&self, points: &[[S; 3]], contains: &mut [bool]) {
        self.bvh.places(Exact::default(), points, contains, |place| place != Place::Outside);
    }
}

/// Why a mesh is no solid.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum SolidError<S = f32> {
    /// An edge is run along more often one way than the other.
    Open {
        /// A triangle that has it.
        triangle: usize,
        /// From where to where it runs there.
        edge: [[S; 3]; 2],
    },
    /// A corner is not finite.
    NotFinite {
        /// Its triangle.
        triangle: usize,
    },
    /// There is no hierarchy over it, or too little memory to check it.
    Build(BuildError),
}

impl<S> From<BuildError> for SolidError<S> {
    fn from(error: BuildError) -> Self {
        Self::Build(error)
    }
}

impl<S: Scalar> fmt::Display for SolidError<S> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Open { triangle, edge: [from, to] } => {
                write!(
                    f,
                    "the mesh is open: nothing meets triangle {triangle} from {from:?} to {to:?}"
                )
            }
            Self::NotFinite { triangle } => {
                write!(f, "triangle {triangle} has a corner that is not finite")
            }
            Self::Build(error) => error.fmt(f),
        }
    }
}

impl<S: Scalar> std::error::Error for SolidError<S> {}
