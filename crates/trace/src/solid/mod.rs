//! Solids: tests whether points are inside a mesh, based on winding numbers.

mod angle;
mod boundary;
mod classify;
mod cluster;
mod distance;
mod edges;
mod grid;
mod grid_surface;
mod orient;
mod report;
mod seen_corner;
mod whole_turns;
mod winding;

use std::fmt;
use std::sync::Arc;

use intertri::{Scalar, TriangleOf};

use crate::build::BuildError;
use crate::bvh::Bvh;
use crate::containment::Containment;
use crate::scalar::BvhScalar;
use crate::util::memory::NoMemory;
use boundary::Boundary;
pub use classify::WINDING_DIR;
pub(crate) use classify::classify;
use classify::classify_batch;
use edges::{Edges, is_finite};
pub use orient::Orientation;
pub use report::{DefectiveEdge, DuplicateTriangle, MeshReport};

/// A mesh and its hierarchy, with tests for whether points are inside the mesh.
///
/// Use [`Solid::new`] for a closed mesh, in which triangles traverse every edge equally often in
/// both directions. The distinction between inside and outside is then exact. The mesh may have
/// several parts, intersect itself, and contain duplicate triangles or triangles with zero area.
/// For any other mesh, use [`Solid::from_soup`], which rounds winding numbers. Clones share the
/// hierarchy.
///
/// ```
/// use intertri_trace::{Containment, Solid, intertri::Triangle};
/// let [o, x, y, z] = [[0.0; 3], [4.0, 0.0, 0.0], [0.0, 4.0, 0.0], [0.0, 0.0, 4.0]];
/// let faces = [[o, y, x], [o, x, z], [o, z, y], [x, y, z]].map(|[a, b, c]| Triangle::new(a, b, c));
/// let solid = Solid::new(&faces)?;
/// let points = [[1.0, 1.0, 1.0], [3.0, 3.0, 3.0], [1.0, 1.0, 2.0], [1.0, 1.0, 2.000_000_2]];
/// let containments = points.map(|point| solid.classify(point));
/// assert_eq!(containments, [Containment::Inside(1), Containment::Outside, Containment::Surface, Containment::Outside]);
/// assert!(Solid::new(&faces[1..]).unwrap_err().to_string().contains("not closed"));
/// # Ok::<(), intertri_trace::SolidError>(())
/// ```
#[derive(Clone, Debug)]
pub struct Solid<S: BvhScalar = f32> {
    bvh: Arc<Bvh<S>>,
    boundary: Boundary<S>,
}

impl<S: BvhScalar> Solid<S> {
    /// Creates a solid from a closed mesh.
    ///
    /// # Errors
    /// Returns an error if the mesh is open or not finite, or if the hierarchy cannot be built.
    pub fn new(triangles: &[TriangleOf<S>]) -> Result<Self, SolidError<S>> {
        Self::check_closed(triangles)?;
        Ok(Self::assume_closed(triangles)?)
    }

    /// Checks whether triangles meet the requirements of [`Solid::new`], without building a
    /// hierarchy over them.
    ///
    /// # Errors
    /// Returns an error if the mesh is open or not finite, or if memory runs out.
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
        if let Some(triangle) = triangles.iter().position(|triangle| !is_finite(triangle)) {
            return Err(SolidError::NotFinite { triangle });
        }
        let is_closed =
            Edges::of(triangles).map(|edges| edges.shared().all(|edge| edge.is_closed()));
        match is_closed {
            Ok(true) => Ok(()),
            Ok(false) => Err(SolidError::Open(Box::new(Self::inspect(triangles)?))),
            Err(NoMemory) => Err(BuildError::OutOfMemory { count: triangles.len() }.into()),
        }
    }

    /// Reports any reasons why triangles do not form a closed mesh, and any duplicate triangles.
    ///
    /// # Errors
    /// Returns an error if memory runs out.
    pub fn inspect(triangles: &[TriangleOf<S>]) -> Result<MeshReport<S>, BuildError> {
        let out_of_memory = |NoMemory| BuildError::OutOfMemory { count: triangles.len() };
        MeshReport::of(triangles).map_err(out_of_memory)
    }

    /// Creates a solid from any mesh and treats it as closed. If the mesh is open, results depend
    /// on the direction in which crossings are counted.
    ///
    /// # Errors
    /// Returns an error if the hierarchy cannot be built.
    pub fn assume_closed(triangles: &[TriangleOf<S>]) -> Result<Self, BuildError> {
        Ok(Self::assume_closed_bvh(Bvh::new(triangles)?))
    }

    /// Like [`Solid::assume_closed`], but takes an existing hierarchy, such as a loaded or refitted
    /// one. All its geometries together form the mesh, whatever their masks.
    pub fn assume_closed_bvh(bvh: Bvh<S>) -> Self {
        Self { bvh: Arc::new(bvh), boundary: Boundary::none() }
    }

    /// Returns the hierarchy over the mesh. If other solids share it, such as one from
    /// [`Solid::with_boundary`], this method makes a copy.
    pub fn into_bvh(self) -> Bvh<S> {
        Arc::unwrap_or_clone(self.bvh)
    }

    /// Returns the shared hierarchy. Use it to create instances of the mesh in a
    /// [`Scene`](crate::Scene).
    pub fn shared_bvh(&self) -> Arc<Bvh<S>> {
        self.bvh.clone()
    }

    /// Returns the hierarchy over the mesh.
    pub fn bvh(&self) -> &Bvh<S> {
        &self.bvh
    }

    /// Classifies a point. It is inside if the [winding number](Self::winding_number), rounded to
    /// the nearest integer, is not 0. For a mesh whose corners run counter-clockwise as seen from
    /// outside, this means a winding number above 1/2. A non-finite point is outside.
    pub fn classify(&self, point: [S; 3]) -> Containment {
        self.counted(point, classify(&self.bvh, point))
    }

    /// Like [`Solid::classify`], but for many points.
    pub fn classify_batch(&self, points: &[[S; 3]]) -> Vec<Containment> {
        let mut all = vec![Containment::Outside; points.len()];
        self.classify_batch_into(points, &mut all);
        all
    }

    /// Like [`Solid::classify_batch`], but writes the results to a slice.
    ///
    /// # Panics
    /// Panics if the slices differ in length.
    pub fn classify_batch_into(&self, points: &[[S; 3]], all: &mut [Containment]) {
        classify_batch(&self.bvh, points, all, |rays, crossed, all| {
            self.count_boundary(rays, crossed);
            all.copy_from_slice(crossed);
        });
    }

    /// Returns, for each point, whether it is inside the mesh or on its surface.
    pub fn contains_batch(&self, points: &[[S; 3]]) -> Vec<bool> {
        let mut contains = vec![false; points.len()];
        self.contains_batch_into(points, &mut contains);
        contains
    }

    /// Like [`Solid::contains_batch`], but writes the results to a slice.
    ///
    /// # Panics
    /// Panics if the slices differ in length.
    pub fn contains_batch_into(&self, points: &[[S; 3]], contains: &mut [bool]) {
        classify_batch(&self.bvh, points, contains, |rays, crossed, contains| {
            self.count_boundary(rays, crossed);
            for (contains, containment) in contains.iter_mut().zip(crossed) {
                *contains = *containment != Containment::Outside;
            }
        });
    }
}

/// The reason that a mesh is not a solid.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum SolidError<S = f32> {
    /// Triangles traverse some edges more often in one direction than in the other: these edges are
    /// open, or their triangles are flipped or duplicated.
    Open(Box<MeshReport<S>>),
    /// A corner is not finite.
    NotFinite {
        /// The triangle that has the non-finite corner.
        triangle: usize,
    },
    /// The hierarchy could not be built, or memory ran out while checking the mesh.
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
            Self::Open(report) => write!(f, "the mesh is not closed: {report}"),
            Self::NotFinite { triangle } => {
                write!(f, "triangle {triangle} has a corner that is not finite")
            }
            Self::Build(error) => error.fmt(f),
        }
    }
}

impl<S: Scalar> std::error::Error for SolidError<S> {}
