//! Queries over f32 and f64 slices. They are compiled in this crate for each scalar type; generic
//! functions would be compiled again in every crate that calls them.

use alloc::vec::Vec;

use super::mode::{Arithmetic, Mode};
use super::rows::Rows;
use super::{document64, exact64, slices};
use crate::exact::{Side, facing};
use crate::{Crossing, Hit, Ray, Ray64, RayOf, Scalar, Triangle, Triangle64, TriangleOf};

/// Queries over slices.
impl Mode {
    /// Returns the closest hit.
    ///
    /// ```
    /// use intertri::{Mode, Ray, Ray64, Triangle, Triangle64};
    /// let near = Triangle::new([0.0, 0.0, 5.0], [1.0, 0.0, 5.0], [0.0, 1.0, 5.0]);
    /// let far = Triangle::new([0.0, 0.0, 9.0], [1.0, 0.0, 9.0], [0.0, 1.0, 9.0]);
    /// let ray = Ray::new([0.25, 0.25, 0.0], [0.0, 0.0, 2.0]);
    /// let hit = Mode::certified().closest(&[far, near], &ray).unwrap();
    /// assert_eq!((hit.triangle, hit.t, hit.u, hit.v), (1, 2.5, 0.25, 0.25));
    ///
    /// // A wall at UTM coordinates, in f64, and a ray that starts a nanometre away from it.
    /// let [x, y] = [148_376.0, 528_980.0];
    /// let wall = Triangle64::new([x, y, 0.0], [x, y + 4.0, 0.0], [x, y, 3.0]);
    /// let ray = |dir| Ray64::new([x + 1e-9, y + 1.0, 1.0], [dir, 0.0, 0.0]);
    /// assert!(!Mode::exact().any(&[wall], &ray(1.0)));
    /// assert_eq!(Mode::exact().closest(&[wall], &ray(-1.0)).map(|hit| hit.t), Some(ray(1.0).origin[0] - x));
    /// ```
    pub fn closest<S: SliceScalar>(
        self,
        triangles: &[TriangleOf<S>],
        ray: &RayOf<S>,
    ) -> Option<Hit> {
        S::closest(self, triangles, ray)
    }

    /// Returns whether the ray hits anything.
    ///
    /// ```
    /// use intertri::{Mode, Ray, Triangle};
    /// let wall = Triangle::new([0.0, 0.0, 5.0], [1.0, 0.0, 5.0], [0.0, 1.0, 5.0]);
    /// let ray = Ray::new([0.25, 0.25, 0.0], [0.0, 0.0, 1.0]);
    /// assert!(Mode::exact().any(&[wall], &ray));
    /// // The interval is open at its far end.
    /// assert!(!Mode::exact().any(&[wall], &ray.between(0.0, 5.0)));
    /// ```
    pub fn any<S: SliceScalar>(self, triangles: &[TriangleOf<S>], ray: &RayOf<S>) -> bool {
        S::any(self, triangles, ray)
    }

    /// Returns every hit, sorted by t and, for equal t, by index.
    ///
    /// ```
    /// use intertri::{Mode, Ray, Triangle};
    /// let at = |z| Triangle::new([0.0, 0.0, z], [1.0, 0.0, z], [0.0, 1.0, z]);
    /// let ray = Ray::new([0.25, 0.25, 0.0], [0.0, 0.0, 1.0]);
    /// let hits = Mode::exact().all(&[at(5.0), at(-1.0), at(3.0)], &ray);
    /// assert!(hits.iter().map(|hit| hit.triangle).eq([2, 0]));
    /// ```
    pub fn all<S: SliceScalar>(self, triangles: &[TriangleOf<S>], ray: &RayOf<S>) -> Vec<Hit> {
        S::all(self, triangles, ray)
    }

    /// Returns the crossings of a ray with a surface, sorted by t and, for equal t, by index.
    ///
    /// A point on an edge or a corner belongs to only one of the triangles that share it, as in
    /// [`Mode::once`]. For a closed mesh, the number of crossings in the direction of the normal
    /// minus the number of crossings against it is therefore the winding number around the ray's
    /// origin. Crossings are decided exactly in every mode.
    ///
    /// ```
    /// use intertri::{Mode, Ray, Triangle};
    /// let [a, b, c, d] = [[0.0, 0.0, 5.0], [1.0, 0.0, 5.0], [0.0, 1.0, 5.0], [1.0, 1.0, 5.0]];
    /// let square = [Triangle::new(a, b, c), Triangle::new(d, c, b)];
    /// let crossings = Mode::exact().crossings(&square, &Ray::new([0.3, 0.7, 0.0], [0.0, 0.0, 3.0]));
    /// assert!(crossings.len() == 1 && crossings[0].leaves);
    /// ```
    pub fn crossings<S: SliceScalar>(
        self,
        triangles: &[TriangleOf<S>],
        ray: &RayOf<S>,
    ) -> Vec<Crossing> {
        let side = |hit: &Hit| facing(ray, &triangles[hit.triangle as usize]);
        let crossing = |hit: Hit| Crossing { leaves: side(&hit) == Some(Side::Leaves), hit };
        Self::once().at(self.level()).all(triangles, ray).into_iter().map(crossing).collect()
    }

    /// Like [`Mode::closest`], but for many rays: `hits[i]` becomes the closest hit of `rays[i]`,
    /// or [`Hit::MISS`]. For several f32 rays, the triangles are loaded into lanes only once.
    ///
    /// # Panics
    /// Panics if the slices differ in length.
    ///
    /// ```
    /// use intertri::{Hit, Mode, Ray, Triangle};
    /// let wall = Triangle::new([0.0, 0.0, 5.0], [1.0, 0.0, 5.0], [0.0, 1.0, 5.0]);
    /// let rays = [0.25, 2.0].map(|x| Ray::new([x, 0.25, 0.0], [0.0, 0.0, 1.0]));
    /// let mut hits = [Hit::MISS; 2];
    /// Mode::exact().closest_batch(&[wall], &rays, &mut hits);
    /// assert_eq!(hits.map(|hit| hit.is_hit()), [true, false]);
    /// ```
    pub fn closest_batch<S: SliceScalar>(
        self,
        triangles: &[TriangleOf<S>],
        rays: &[RayOf<S>],
        hits: &mut [Hit],
    ) {
        assert_eq!(rays.len(), hits.len(), "`rays` and `hits` must have the same length");
        S::closest_batch(self, triangles, rays, hits);
    }
}

/// A scalar type whose slices [`Mode`] accepts: f32 or f64. Do not implement this trait for
/// other types.
///
/// ```
/// use intertri::{Mode, RayOf, SliceScalar, TriangleOf};
/// /// Counts the triangles that a ray hits, for either scalar type.
/// fn depth<S: SliceScalar>(triangles: &[TriangleOf<S>], ray: &RayOf<S>) -> usize {
///     Mode::exact().all(triangles, ray).len()
/// }
/// ```
pub trait SliceScalar: Scalar {
    #[doc(hidden)]
    fn closest(mode: Mode, triangles: &[TriangleOf<Self>], ray: &RayOf<Self>) -> Option<Hit>;
    #[doc(hidden)]
    fn any(mode: Mode, triangles: &[TriangleOf<Self>], ray: &RayOf<Self>) -> bool;
    #[doc(hidden)]
    fn all(mode: Mode, triangles: &[TriangleOf<Self>], ray: &RayOf<Self>) -> Vec<Hit>;
    #[doc(hidden)]
    fn closest_batch(
        mode: Mode,
        triangles: &[TriangleOf<Self>],
        rays: &[RayOf<Self>],
        hits: &mut [Hit],
    );
}

impl SliceScalar for f32 {
    fn closest(mode: Mode, triangles: &[Triangle], ray: &Ray) -> Option<Hit> {
        slices::closest(mode.filter(), Rows::Slice(triangles), ray)
    }

    fn any(mode: Mode, triangles: &[Triangle], ray: &Ray) -> bool {
        slices::any(mode.filter(), Rows::Slice(triangles), ray)
    }

    fn all(mode: Mode, triangles: &[Triangle], ray: &Ray) -> Vec<Hit> {
        slices::all(mode.filter(), Rows::Slice(triangles), ray)
    }

    fn closest_batch(mode: Mode, triangles: &[Triangle], rays: &[Ray], hits: &mut [Hit]) {
        slices::closest_batch(mode.filter(), triangles, rays, hits);
    }
}

impl SliceScalar for f64 {
    fn closest(mode: Mode, triangles: &[Triangle64], ray: &Ray64) -> Option<Hit> {
        match mode.arithmetic() {
            Arithmetic::Exact(rule) => exact64::closest(rule, mode.level(), triangles, ray),
            Arithmetic::Document(threshold) => document64::closest(threshold, triangles, ray),
        }
    }

    fn any(mode: Mode, triangles: &[Triangle64], ray: &Ray64) -> bool {
        match mode.arithmetic() {
            Arithmetic::Exact(rule) => exact64::any(rule, mode.level(), triangles, ray),
            Arithmetic::Document(threshold) => document64::any(threshold, triangles, ray),
        }
    }

    fn all(mode: Mode, triangles: &[Triangle64], ray: &Ray64) -> Vec<Hit> {
        match mode.arithmetic() {
            Arithmetic::Exact(rule) => exact64::all(rule, mode.level(), triangles, ray),
            Arithmetic::Document(threshold) => document64::all(threshold, triangles, ray),
        }
    }

    fn closest_batch(mode: Mode, triangles: &[Triangle64], rays: &[Ray64], hits: &mut [Hit]) {
        for (ray, hit) in rays.iter().zip(hits) {
            *hit = Self::closest(mode, triangles, ray).unwrap_or(Hit::MISS);
        }
    }
}
