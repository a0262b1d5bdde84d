//! Document D (`docs/documents.md`): the coefficients of a triangle for many rays from one origin,
//! by Cramer's rule.
//!
//! ```text
//!   A = c1 - o      n = h4 × h5       D = n·d             Each is a dot product with the direction.
//!   h4 = c2 - c1    V = h5 × A        u = V·d / D         The vectors are computed once
//!   h5 = c3 - c1    W = A × h4        v = W·d / D         for a triangle and an origin.
//!                                     t = n·A / D
//! ```
//!
//! The filter and the z-buffer use these coefficients for rays from one origin. The coefficients
//! also yield the weights of every hit.

use crate::Triangle;
use crate::simd::Lanes;
use crate::simd::Vec3;

/// The coefficients of one triangle relative to one origin in f64, or of several triangles in
/// lanes.
///
/// ```
/// use intertri::internal::Coefficients;
/// use intertri::Triangle;
/// // Seen from the middle of a side, straight ahead.
/// let triangle = Triangle::new([0.0, 0.0, 5.0], [1.0, 0.0, 5.0], [0.0, 1.0, 5.0]);
/// let seen = Coefficients::new(&triangle, [0.5, 0.5, 0.0]);
/// assert_eq!(seen.weights([0.0, 0.0, 1.0]), (0.5, 0.5));
/// // If the line passes by the triangle, a weight is negative.
/// assert!(seen.weights([0.0, -2.0, 1.0]).1 < 0.0);
/// ```
#[derive(Clone, Copy, Debug)]
pub struct Coefficients<D = f64> {
    /// `c1 - o`
    pub(crate) a: Vec3<D>,
    /// The coefficients of the common denominator, which are the triangle's normal.
    pub(crate) n: Vec3<D>,
    /// The coefficients of u, the weight of c2.
    pub(crate) v: Vec3<D>,
    /// The coefficients of v, the weight of c3.
    pub(crate) w: Vec3<D>,
}

impl<D: Lanes<Scalar = f64>> Coefficients<D> {
    /// Computes the coefficients of triangles relative to an origin.
    #[inline(always)]
    pub(crate) fn of([c1, c2, c3]: [Vec3<D>; 3], origin: Vec3<D>) -> Self {
        Self::along(c1 - origin, c2 - c1, c3 - c1)
    }

    /// Computes the coefficients from the vector to c1 and the edges, in any coordinate system.
    #[inline(always)]
    pub(crate) fn along(a: Vec3<D>, h4: Vec3<D>, h5: Vec3<D>) -> Self {
        Self { a, n: h4.cross(h5), v: h5.cross(a), w: a.cross(h4) }
    }
}

impl Coefficients {
    /// Computes the coefficients of a triangle relative to an origin.
    #[inline]
    pub fn new(triangle: &Triangle, origin: [f32; 3]) -> Self {
        let vec3 = |v: [f32; 3]| Vec3::<f64>::splat(v.map(f64::from));
        Self::of(triangle.0.map(vec3), vec3(origin))
    }

    /// Returns the weights u of c2 and v of c3 at the point where the line through the origin along
    /// `dir` intersects the triangle's plane, inside or outside the triangle. The length of `dir`
    /// does not matter. The weights are not finite if the line is parallel to the plane or an input
    /// is not finite.
    ///
    /// ```
    /// use intertri::internal::Coefficients;
    /// use intertri::Triangle;
    /// let triangle = Triangle::new([0.0, 0.0, 5.0], [1.0, 0.0, 5.0], [0.0, 1.0, 5.0]);
    /// let seen = Coefficients::new(&triangle, [0.25, 0.5, 0.0]);
    /// assert_eq!(seen.weights([0.0, 0.0, 2.0]), (0.25, 0.5));
    /// ```
    #[inline]
    pub fn weights(&self, dir: [f64; 3]) -> (f64, f64) {
        let dir = Vec3::splat(dir);
        let den = self.n.dot(dir);
        (self.v.dot(dir) / den, self.w.dot(dir) / den)
    }
}
