//! Media: closed meshes filled with materials, and the sequence of materials along a ray.
//!
//! ```text
//!                ┌───────── rock ─────────┐
//!                │     ┌── steel ──┐      │
//!   ray ─────────┼─────┼───────────┼──────┼───────▶
//!      outside   │ rock│   steel   │ rock │ outside
//! ```

mod batches;
mod path;
mod segment;

pub use segment::{MediumCrossing, Segment};

use std::fmt;

use intertri::{Crossing, RayOf, Scalar, TriangleOf};

use crate::build::BuildError;
use crate::bvh::Bvh;
use crate::scalar::BvhScalar;
use crate::solid::{Solid, SolidError, WINDING_DIR};
use path::Path;

/// A set of closed meshes in one hierarchy, each filled with a medium. Use it to follow particles
/// from medium to medium.
///
/// Each mesh is a geometry of the hierarchy, in the given order. Meshes may be nested, touch, or
/// overlap: where several meshes wind around a point, the last one in the list determines its
/// medium, so list them from the outside in. Where no mesh winds around a point, the medium is
/// `None`, that is, the outside.
///
/// Every point in space and every part of a ray has exactly one medium. Crossings at the same t are
/// evaluated together, so touching solids have no gap between them, and the order of crossings is
/// exact. A ray that starts on a wall starts in the medium that it enters. A ray that runs along a
/// wall passes the wall's corners on a definite side, which is the same for all triangles and
/// meshes; this is the rule of [`Query::crossings`](crate::Query::crossings).
///
/// ```
/// use intertri_trace::{Media, intertri::{Ray, Triangle}};
/// let tetrahedron = |x: f32, size: f32| {
///     let at = |a, b, c| [x + a * size, b * size, c * size];
///     let [o, x, y, z] = [at(0.0, 0.0, 0.0), at(1.0, 0.0, 0.0), at(0.0, 1.0, 0.0), at(0.0, 0.0, 1.0)];
///     [[o, y, x], [o, x, z], [o, z, y], [x, y, z]].map(|[a, b, c]| Triangle::new(a, b, c))
/// };
/// const ROCK: u32 = 7;
/// const STEEL: u32 = 3;
/// // Steel in a corner of the rock, and more steel behind it.
/// let media = Media::new(&[
///     (ROCK, &tetrahedron(0.0, 8.0)),
///     (STEEL, &tetrahedron(0.0, 2.0)),
///     (STEEL, &tetrahedron(7.0, 2.0)),
/// ])?;
/// assert_eq!(media.medium_at([0.5, 0.5, 0.5]), Some(STEEL));
///
/// let ray = Ray::new([-1.0, 0.5, 0.5], [1.0, 0.0, 0.0]);
/// let segments = media.segments(&ray);
/// assert!(segments.iter().map(|s| (s.medium, s.end)).eq([
///     (None, 1.0),
///     (Some(STEEL), 2.0),
///     (Some(ROCK), 8.0),
///     (Some(STEEL), 9.0),
///     (None, f64::INFINITY),
/// ]));
/// let next = media.next_crossing(&ray).unwrap();
/// assert_eq!((next.hit.t, next.left, next.entered), (1.0, None, Some(STEEL)));
/// # Ok::<(), intertri_trace::MediaError>(())
/// ```
#[derive(Clone, Debug)]
pub struct Media<S: BvhScalar = f32> {
    bvh: Bvh<S>,
    /// The medium of each geometry.
    media: Vec<u32>,
}

impl<S: BvhScalar> Media<S> {
    /// Builds media from closed meshes. Each mesh is paired with a medium number of your choice;
    /// meshes with the same number form one medium.
    ///
    /// # Errors
    /// Returns an error if a mesh is not closed or not finite, or if the hierarchy cannot be built.
    pub fn new(meshes: &[(u32, &[TriangleOf<S>])]) -> Result<Self, MediaError<S>> {
        for (mesh, (_, triangles)) in meshes.iter().enumerate() {
            Solid::check_closed(triangles).map_err(|error| match error {
                SolidError::Build(error) => MediaError::Build(error),
                error => MediaError::Mesh { mesh, error },
            })?;
        }
        let triangles: Vec<_> = meshes.iter().map(|(_, triangles)| *triangles).collect();
        let bvh = Bvh::from_meshes(&triangles).map_err(MediaError::Build)?;
        Ok(Self { bvh, media: meshes.iter().map(|(medium, _)| *medium).collect() })
    }

    /// Returns the hierarchy over the meshes.
    pub fn bvh(&self) -> &Bvh<S> {
        &self.bvh
    }

    /// Returns the medium of each mesh.
    pub fn media(&self) -> &[u32] {
        &self.media
    }

    /// Returns the medium at a point, or `None` if the point is outside all meshes or not finite.
    /// If the point lies on a wall, returns the medium that a small step along (0.537, 0.351,
    /// 0.767) enters.
    pub fn medium_at(&self, point: [S; 3]) -> Option<u32> {
        let ray = toward_outside(point);
        self.path(&ray, &self.bvh.crossings(&ray)).medium()
    }

    /// Returns the next crossing of a ray into another medium, if there is one before `t_max`.
    pub fn next_crossing(&self, ray: &RayOf<S>) -> Option<MediumCrossing> {
        self.path(ray, &self.bvh.crossings(&endless(ray))).next_crossing()
    }

    /// Splits a ray where its medium changes. The segments cover the ray from `t_min` to `t_max`;
    /// each starts where the previous one ends. Segments whose two ends round to the same t are
    /// omitted. The length of a segment in space is `end - start` times the length of the
    /// direction. If the direction is zero or non-finite, or the origin is non-finite, the ray
    /// counts as outside all meshes.
    pub fn segments(&self, ray: &RayOf<S>) -> Vec<Segment> {
        let crossings = self.bvh.crossings(&endless(ray));
        let mut segments: Vec<Segment> = self.path(ray, &crossings).collect();
        segments.reverse();
        segments
    }

    /// Returns the segments of a ray, given all crossings after its start.
    fn path<'a>(&'a self, ray: &RayOf<S>, crossings: &'a [Crossing]) -> Path<'a> {
        Path::new(&self.media, ray, crossings)
    }
}

/// Returns a copy of a ray that extends to infinity, because the winding numbers at the ray's start
/// depend on all crossings.
fn endless<S: Scalar>(ray: &RayOf<S>) -> RayOf<S> {
    RayOf { t_max: S::INFINITY, ..*ray }
}

/// Creates a ray from a point, in the direction that decides which side of a wall the point is on.
fn toward_outside<S: Scalar>(point: [S; 3]) -> RayOf<S> {
    RayOf::new(point, WINDING_DIR.map(S::from))
}

/// The reason that media could not be built.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum MediaError<S = f32> {
    /// A mesh is not closed or not finite.
    Mesh {
        /// The index of the mesh.
        mesh: usize,
        /// The reason that the mesh was rejected.
        error: SolidError<S>,
    },
    /// The hierarchy could not be built, or memory ran out.
    Build(BuildError),
}

impl<S: Scalar> fmt::Display for MediaError<S> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Mesh { mesh, error } => write!(f, "mesh {mesh} is not a solid: {error}"),
            Self::Build(error) => error.fmt(f),
        }
    }
}

impl<S: Scalar> std::error::Error for MediaError<S> {}
