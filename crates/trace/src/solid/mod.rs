//! Solids: what a closed mesh winds around.

mod boundary;
mod classify;
mod distance;

use std::fmt;

use intertri::{Scalar, TriangleOf};

use crate::build::BuildError;
use crate::bvh::Bvh;
use crate::containment::Containment;
use crate::scalar::BvhScalar;
use crate::util::memory::NoMemory;
use boundary::open_edge;
pub(crate) use classify::classify;
use classify::classify_batch;

/// A closed mesh, and the hierarchy over it: it knows inside from outside, exactly.
///
/// In a closed mesh every edge runs as often one way as the other. The mesh may be in parts, meet itself, and have
/// triangles twice or without area.
///
/// ```
/// use intertri_trace::{Containment, Solid, intertri::Triangle};
/// let [o, x, y, z] = [[0.0; 3], [4.0, 0.0, 0.0], [0.0, 4.0, 0.0], [0.0, 0.0, 4.0]];
/// let faces = [[o, y, x], [o, x, z], [o, z, y], [x, y, z]].map(|[a, b, c]| Triangle::new(a, b, c));
/// let solid = Solid::new(&faces)?;
/// let points = [[1.0, 1.0, 1.0], [3.0, 3.0, 3.0], [1.0, 1.0, 2.0], [1.0, 1.0, 2.000_000_2]];
/// let containments = points.map(|point| solid.classify(point));
/// assert_eq!(containments, [Containment::Inside(1), Containment::Outside, Containment::Surface, Containment::Outside]);
/// assert!(Solid::new(&faces[1..]).unwrap_err().to_string().contains("is open"));
/// # Ok::<(), intertri_trace::SolidError>(())
/// ```
#[derive(Clone, Debug)]
pub struct Solid<S: BvhScalar = f32> {
    bvh: Bvh<S>,
}

impl<S: BvhScalar> Solid<S> {
    /// Of a closed mesh.
    ///
    /// # Errors
    /// If it is open, something is not finite, or there is no hierarchy over it.
    pub fn new(triangles: &[TriangleOf<S>]) -> Result<Self, SolidError<S>> {
        Self::check_closed(triangles)?;
        Ok(Self::assume_closed(triangles)?)
    }

    /// What [`Solid::new`] requires of triangles, without building a hierarchy.
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

    /// Where a point lies. A point that is not finite is outside.
    pub fn classify(&self, point: [S; 3]) -> Containment {
        classify(&self.bvh, point)
    }

    /// [`Solid::classify`] of many points.
    pub fn classify_batch(&self, points: &[[S; 3]]) -> Vec<Containment> {
        let mut all = vec![Containment::Outside; points.len()];
        self.classify_batch_into(points, &mut all);
        all
    }

    /// [`Solid::classify_batch`] into a slice.
    ///
    /// # Panics
    /// If the slices differ in length.
    pub fn classify_batch_into(&self, points: &[[S; 3]], all: &mut [Containment]) {
        classify_batch(&self.bvh, points, all, |containment| containment);
    }

    /// Which of many points are inside or on the surface.
    pub fn contains_batch(&self, points: &[[S; 3]]) -> Vec<bool> {
        let mut contains = vec![false; points.len()];
        self.contains_batch_into(points, &mut contains);
        contains
    }

    /// [`Solid::contains_batch`] into a slice.
    ///
    /// # Panics
    /// If the slices differ in length.
    pub fn contains_batch_into(&self, points: &[[S; 3]], contains: &mut [bool]) {
        let is_held = |containment| containment != Containment::Outside;
        classify_batch(&self.bvh, points, contains, is_held);
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
    /// The hierarchy could not be built, or there is too little memory to check the mesh.
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
