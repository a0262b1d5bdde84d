//! Document A: tests whether one ray hits one triangle.
//!
//! ```text
//!                c3
//!               /  \             h4 = c2 - c1     nrm = (h4 ^ h5) / |h4 ^ h5|
//!              /     \  h6       h5 = c3 - c1
//!          h5 /  h1    \         h6 = c3 - c2
//!            /  .    .   \
//!           / h2   h3  .   \     h1 = org + dir * t, the point in the plane
//!          /.            .   \   h2 = h1 - c1
//!         c1 ------------------ c2     h3 = h1 - c2
//!                   h4
//! ```
//!
//! The point is inside if the cross product of each side with the vector to the point has the same
//! direction as the normal. The triangle is two-sided: the sign of `nrm & dir` does not matter.
//!
//! # What the document leaves open, and the choices made here
//! - **The length of the normal.** The document only says that triangles are "initialised in a
//!   special way". Here `nrm` has length 1, so that the parallel test does not depend on the size
//!   of the triangle. The test does depend on the length of `dir`.
//! - **The value of `Threshold`.** The document does not give one. Here, it is a field of
//!   [`Scene`], which is [`THRESHOLD`] by default. It serves two purposes: it is the smallest
//!   `|nrm & dir|` that does not count as parallel, and the largest `t` that does not count as a
//!   hit.
//!
//! # Edge cases of the listing, kept as they are
//! - A triangle with **zero area** has `nrm = 0` and is parallel to every ray. (With a threshold of
//!   0, nothing is parallel; then `t = 0 / 0` is NaN, and the last line rejects it.)
//! - **A miss changes `t`** if an edge test or the last line rejects it; a parallel ray leaves `t`
//!   unchanged.
//! - **NaN passes** the parallel test and all three edge tests, because every comparison with it is
//!   false. The last line, `t > Threshold`, returns 0.
//! - **Infinity**: `t` has no upper bound, so the test can return 1 even if `t` overflows to
//!   infinity. Searches for hits ([`closest`](crate::closest)) use an interval that excludes an
//!   infinite `t`. For an infinite direction, `t` is 0 or NaN; for an infinite origin or vertex,
//!   `t` is infinite or NaN. Therefore, a ray or a triangle that is not finite never yields a hit
//!   with a finite `t` (for a threshold of 0 or more).

use alloc::vec::Vec;
use core::fmt;

use crate::vector::Vector;

/// The default of [`Scene::threshold`].
///
/// In a unit-sized scene, this is far above the rounding errors of f64 (about 1e-16) and far below
/// the size of features. A scene with distances or directions on the order of 1e-9 needs a smaller
/// threshold, such as 0.
pub const THRESHOLD: f64 = 1e-9;

/// A half-line: the points `org + dir * t`. `dir` need not have unit length.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ray {
    /// The point at `t = 0`.
    pub org: Vector,
    /// The direction, and the unit of `t`.
    pub dir: Vector,
}

impl Ray {
    /// Creates a ray from two values that convert to vectors.
    pub fn new(org: impl Into<Vector>, dir: impl Into<Vector>) -> Self {
        Self { org: org.into(), dir: dir.into() }
    }
}

/// A triangle in the table: three vertex indices and the values computed once from them.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Trian {
    /// The first corner, an index into [`Scene::vertx`].
    pub c1: usize,
    /// The second corner.
    pub c2: usize,
    /// The third corner.
    pub c3: usize,
    /// The normal `h4 ^ h5` divided by its length; zero if the triangle has no area.
    pub nrm: Vector,
    /// `c2 - c1`
    pub h4: Vector,
    /// `c3 - c1`
    pub h5: Vector,
    /// `c3 - c2`
    pub h6: Vector,
}

/// The document's two tables and its constant.
///
/// The fields are public, as the document's tables are. If you change them, make sure that the
/// corners in `trian` remain valid indices into `vertx` and that the edges still match the corners.
#[derive(Clone, Debug, PartialEq)]
pub struct Scene {
    /// `Vertx`: the vertices.
    pub vertx: Vec<Vector>,
    /// `Trian`: the triangles.
    pub trian: Vec<Trian>,
    /// `Threshold`: see the [module](self). Any f64 is accepted, even NaN or a negative number.
    pub threshold: f64,
}

/// The error for a triangle that refers to a missing vertex.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct IndexOutOfRange {
    /// The index of the triangle.
    pub triangle: usize,
    /// The index of the missing vertex.
    pub index: usize,
    /// The number of vertices.
    pub vertices: usize,
}

impl fmt::Display for IndexOutOfRange {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { triangle, index, vertices } = self;
        write!(
            f,
            "triangle {triangle} refers to vertex {index}, but there are {vertices} vertices, numbered from 0"
        )
    }
}

impl core::error::Error for IndexOutOfRange {}

impl Scene {
    /// Creates a scene from a vertex table and three vertex indices per triangle, with the default
    /// threshold.
    ///
    /// # Errors
    /// Returns an error if a triangle refers to a missing vertex. The error contains the first such
    /// triangle and its first missing vertex.
    pub fn new(
        vertx: Vec<Vector>,
        corners: impl IntoIterator<Item = [usize; 3]>,
    ) -> Result<Self, IndexOutOfRange> {
        let mut scene = Self { vertx, trian: Vec::new(), threshold: THRESHOLD };
        for corners in corners {
            let vertices = scene.vertx.len();
            if let Some(&index) = corners.iter().find(|&&index| index >= vertices) {
                return Err(IndexOutOfRange { triangle: scene.trian.len(), index, vertices });
            }
            scene.push(corners);
        }
        Ok(scene)
    }

    /// Creates a scene from separate triangles: triangle `i` has the vertices `3i`, `3i+1`, `3i+2`.
    pub fn from_triangles(triangles: impl IntoIterator<Item = [[f32; 3]; 3]>) -> Self {
        let mut scene = Self { vertx: Vec::new(), trian: Vec::new(), threshold: THRESHOLD };
        for triangle in triangles {
            let c1 = scene.vertx.len();
            scene.vertx.extend(triangle.map(Vector::from));
            scene.push([c1, c1 + 1, c1 + 2]);
        }
        scene
    }

    /// Returns the same scene with a different threshold.
    pub fn with_threshold(self, threshold: f64) -> Self {
        Self { threshold, ..self }
    }

    /// Adds a triangle, initialized in the document's "special way": with its edges and its unit
    /// normal.
    fn push(&mut self, [c1, c2, c3]: [usize; 3]) {
        let h4 = self.vertx[c2] - self.vertx[c1];
        let h5 = self.vertx[c3] - self.vertx[c1];
        let h6 = self.vertx[c3] - self.vertx[c2];
        self.trian.push(Trian { c1, c2, c3, nrm: (h4 ^ h5).unit(), h4, h5, h6 });
    }

    /// Returns 1 if the ray meets triangle `obj`, and 0 otherwise. Edges and corners belong to the
    /// triangle.
    ///
    /// `t` becomes the distance to the triangle's plane in multiples of `|dir|`, even if the result
    /// is 0. For a ray parallel to the plane, `t` is unchanged. The [module](self) lists edge
    /// cases.
    ///
    /// # Panics
    /// Panics if there is no triangle `obj`.
    pub fn inter_tri(&self, obj: usize, ray: &Ray, t: &mut f64) -> i32 {
        let tmp = &self.trian[obj];
        let c1 = self.vertx[tmp.c1];
        let c2 = self.vertx[tmp.c2];

        // Is the ray parallel to the plane? The test is written so that NaN does not count as
        // parallel.
        let vd = tmp.nrm & ray.dir;
        if vd > -self.threshold && vd < self.threshold {
            return 0;
        }

        // Find the distance to the plane.
        *t = (tmp.nrm & (c1 - ray.org)) / vd;

        // Intersect the ray with the plane.
        let h1 = ray.org + ray.dir * *t;
        let h2 = h1 - c1;

        // Is that point outside one of the three edges? A point on an edge is not outside.
        if (tmp.nrm & (tmp.h4 ^ h2)) < 0.0
            || (tmp.nrm & (h2 ^ tmp.h5)) < 0.0
            || (tmp.nrm & (tmp.h6 ^ (h1 - c2))) < 0.0
        {
            return 0;
        }

        // Is the point in front of the origin?
        i32::from(*t > self.threshold)
    }

    /// Returns the weights `u` of `c2` and `v` of `c3` at the point where the ray's line meets the
    /// plane of triangle `obj`, so that `c1 + h4 * u + h5 * v = org + dir * t` up to rounding.
    ///
    /// The weights come from Cramer's rule (document D, [`crate::cramer`]) and use neither `t` nor
    /// the normal's length. The point may be outside the triangle. These are the operations, in the
    /// order that determines the bits:
    ///
    /// ```text
    /// a = c1 - org
    /// den = (h4 ^ h5) & dir
    /// u = ((h5 ^ a) & dir) / den
    /// v = ((a ^ h4) & dir) / den
    /// ```
    ///
    /// The weights are infinite or NaN if the ray is parallel to the plane, the triangle has no
    /// area, or an input is not finite.
    ///
    /// # Panics
    /// Panics if there is no triangle `obj`.
    pub fn barycentric(&self, obj: usize, ray: &Ray) -> (f64, f64) {
        let tmp = &self.trian[obj];
        let a = self.vertx[tmp.c1] - ray.org;
        let den = (tmp.h4 ^ tmp.h5) & ray.dir;
        (((tmp.h5 ^ a) & ray.dir) / den, ((a ^ tmp.h4) & ray.dir) / den)
    }
}
