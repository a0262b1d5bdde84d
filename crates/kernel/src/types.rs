//! The types [`Ray`], [`Triangle`], [`Hit`], and [`Hit32`]: plain data that can be cast to and from
//! bytes.

use bytemuck::{Pod, Zeroable};

use crate::Scalar;

/// A half-line, and the interval of t in which its hits count.
///
/// The points of the ray are `origin + t * dir`, so `t` is in multiples of `|dir|`; `dir` need not
/// have unit length. A hit counts if `t_min <= t < t_max` and `t > 0`.
/// [`Mode::exact`](crate::Mode::exact) and [`Mode::once`](crate::Mode::once) compare the true t.
/// [`Mode::certified`](crate::Mode::certified) compares t in f64 and also requires it to be above
/// the mode's threshold. The interval excludes `t_max`, so with the default of infinity, a `t` that
/// overflows is a miss. A ray hits nothing if a component of its origin or direction is NaN or
/// infinite, or if `t_min` or `t_max` is NaN.
///
/// The layout matches a file of raw rays: eight little-endian values per ray, in the order of the
/// fields. [`Ray`] is the f32 type, and [`Ray64`] the f64 type.
///
/// ```
/// let ray = intertri::Ray::new([0.0, 1.0, 0.0], [0.0, 0.0, 2.0]).between(0.5, 9.0);
/// let bytes: [u8; 32] = bytemuck::cast(ray);
/// assert_eq!(bytemuck::cast::<_, intertri::Ray>(bytes), ray);
/// let bytes: [u8; 64] = bytemuck::cast(intertri::Ray64::new([0.0, 1.0, 0.0], [0.0, 0.0, 2.0]));
/// ```
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RayOf<S> {
    /// The point at `t = 0`.
    pub origin: [S; 3],
    /// The start of the interval: hits count only at or above this `t`.
    pub t_min: S,
    /// The direction, whose length is the unit of `t`.
    pub dir: [S; 3],
    /// The end of the interval: hits count only below this `t`.
    pub t_max: S,
}

/// A ray in f32.
pub type Ray = RayOf<f32>;

/// A ray in f64.
pub type Ray64 = RayOf<f64>;

impl<S: Scalar> RayOf<S> {
    /// Creates a ray over the whole half-line, `0 < t < infinity`. A hit at `t = 0` never counts.
    ///
    /// ```
    /// let ray = intertri::Ray::new([0.0, 0.0, 0.0], [0.0, 0.0, 1.0]);
    /// assert_eq!(ray.t_max, f32::INFINITY);
    /// ```
    pub fn new(origin: impl Into<[S; 3]>, dir: impl Into<[S; 3]>) -> Self {
        Self { origin: origin.into(), t_min: S::ZERO, dir: dir.into(), t_max: S::INFINITY }
    }

    /// Returns the same ray with the interval `t_min <= t < t_max`.
    ///
    /// ```
    /// let ray = intertri::Ray::new([0.0; 3], [0.0, 0.0, 1.0]).between(1.0, 5.0);
    /// assert_eq!((ray.t_min, ray.t_max), (1.0, 5.0));
    /// ```
    pub fn between(self, t_min: S, t_max: S) -> Self {
        Self { t_min, t_max, ..self }
    }
}

/// Three corners `c1`, `c2`, `c3`. Both sides can be hit; a point on an edge is inside.
///
/// `bytemuck` casts a buffer of vertices, with nine coordinates per triangle, to a slice of
/// triangles. A triangle is never hit if its area is zero or a coordinate is NaN or infinite.
/// [`Triangle`](type@Triangle) is the f32 type, and [`Triangle64`](type@Triangle64) the f64 type.
///
/// ```
/// let vertices = [0.0, 0.0, 5.0, 1.0, 0.0, 5.0, 0.0, 1.0, 5.0_f32];
/// let triangles: &[intertri::Triangle] = bytemuck::cast_slice(&vertices);
/// let intertri::Triangle([_, _, third]) = triangles[0];
/// assert_eq!(third, [0.0, 1.0, 5.0]);
/// ```
#[repr(transparent)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct TriangleOf<S>(pub [[S; 3]; 3]);

/// A triangle in f32.
pub type Triangle = TriangleOf<f32>;

/// A triangle in f64.
pub type Triangle64 = TriangleOf<f64>;

/// A type alias cannot serve as a constructor or a pattern, but these re-exports make
/// `Triangle(corners)` work as both. The aliases above take precedence as types.
mod constructors {
    pub use super::{TriangleOf as Triangle, TriangleOf as Triangle64};
}
pub use constructors::*;

impl<S: Scalar> TriangleOf<S> {
    /// Creates a triangle from its corners.
    ///
    /// ```
    /// let t = intertri::Triangle::new([0.0, 0.0, 5.0], [1.0, 0.0, 5.0], [0.0, 1.0, 5.0]);
    /// assert_eq!(t.0[1], [1.0, 0.0, 5.0]);
    /// ```
    pub fn new(c1: impl Into<[S; 3]>, c2: impl Into<[S; 3]>, c3: impl Into<[S; 3]>) -> Self {
        Self([c1.into(), c2.into(), c3.into()])
    }

    /// Returns the normal `(c2 - c1) × (c3 - c1)`, in f64. Its length is twice the triangle's area,
    /// and it points to the side from which the corners run counter-clockwise. The normal of a
    /// degenerate triangle is zero, apart from rounding errors.
    ///
    /// ```
    /// let t = intertri::Triangle::new([0.0, 0.0, 5.0], [1.0, 0.0, 5.0], [0.0, 1.0, 5.0]);
    /// assert_eq!(t.normal(), [0.0, 0.0, 1.0]);
    /// ```
    pub fn normal(&self) -> [f64; 3] {
        let [c1, c2, c3]: [[f64; 3]; 3] = self.0.map(|corner| corner.map(Into::into));
        let [x, y, z] = [0, 1, 2].map(|k| c2[k] - c1[k]);
        let [u, v, w] = [0, 1, 2].map(|k| c3[k] - c1[k]);
        [y * w - z * v, z * u - x * w, x * v - y * u]
    }
}

/// The point where a ray meets a triangle, 32 bytes in size.
///
/// The point is `origin + t * dir` and, up to rounding, `(1 - u - v) c1 + u c2 + v c3`. The weights
/// `u` and `v` are the same on every CPU but may be outside `0..=1` because of rounding. Single-ray
/// queries return an `Option<Hit>`; batches fill slices with plain hits, with [`Hit::MISS`] for a
/// miss.
///
/// ```
/// use intertri::{Hit, Mode, Ray, Triangle};
/// let wall = Triangle::new([0.0, 0.0, 5.0], [1.0, 0.0, 5.0], [0.0, 1.0, 5.0]);
/// let ray = Ray::new([0.25, 0.5, 0.0], [0.0, 0.0, 2.0]);
/// let hit = Mode::certified().closest(&[wall], &ray).unwrap();
/// assert_eq!(hit, Hit { t: 2.5, u: 0.25, v: 0.5, triangle: 0, geometry: 0 });
/// assert_eq!(hit.point(&ray), [0.25, 0.5, 5.0]);
/// ```
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct Hit {
    /// Distance along the ray in multiples of `|dir|`; infinity for a miss.
    pub t: f64,
    /// The weight of the second corner.
    pub u: f64,
    /// The weight of the third corner.
    pub v: f64,
    /// The index of the triangle, or [`Hit::NO_TRIANGLE`].
    pub triangle: u32,
    /// The index of the mesh in a hierarchy over several meshes; otherwise 0.
    pub geometry: u32,
}

const _: () = assert!(size_of::<Hit>() == 32);

impl Hit {
    /// The triangle index of a miss.
    ///
    /// ```
    /// assert_eq!(intertri::Hit::MISS.triangle, intertri::Hit::NO_TRIANGLE);
    /// ```
    pub const NO_TRIANGLE: u32 = u32::MAX;

    /// The result in a batch for a ray that hits nothing.
    ///
    /// ```
    /// use intertri::{Hit, Mode, Ray};
    /// let mut hits = [Hit { triangle: 7, ..Hit::MISS }];
    /// Mode::certified().closest_batch(&[], &[Ray::new([0.0; 3], [0.0, 0.0, 1.0])], &mut hits);
    /// assert_eq!(hits, [Hit::MISS]);
    /// ```
    pub const MISS: Self =
        Self { t: f64::INFINITY, u: 0.0, v: 0.0, triangle: Self::NO_TRIANGLE, geometry: 0 };

    /// Returns whether this is a hit.
    ///
    /// ```
    /// assert!(!intertri::Hit::MISS.is_hit());
    /// ```
    #[inline]
    pub fn is_hit(&self) -> bool {
        self.triangle != Self::NO_TRIANGLE
    }

    /// Returns the hit, or `None` for a miss.
    ///
    /// ```
    /// assert_eq!(intertri::Hit::MISS.some(), None);
    /// ```
    #[inline]
    pub fn some(self) -> Option<Self> {
        self.is_hit().then_some(self)
    }

    /// Returns the point `origin + t * dir`, computed in f64. It is not finite for a miss.
    ///
    /// ```
    /// use intertri::{Hit, Ray};
    /// let hit = Hit { t: 2.5, u: 0.0, v: 0.0, triangle: 0, geometry: 0 };
    /// assert_eq!(hit.point(&Ray::new([1.0, 0.0, 0.0], [0.0, 0.0, 2.0])), [1.0, 0.0, 5.0]);
    /// ```
    pub fn point<S: Scalar>(&self, ray: &RayOf<S>) -> [f64; 3] {
        [0, 1, 2].map(|k| ray.origin[k].into() + self.t * ray.dir[k].into())
    }
}

/// A [`Hit`] with t, u, and v in f32, 20 bytes in size.
///
/// In [`Mode::exact`](crate::Mode::exact) and [`Mode::once`](crate::Mode::once), t, u, and v are
/// the true values, correctly rounded to f32. In [`Mode::certified`](crate::Mode::certified), they
/// are the values in [`Hit`], rounded to f32. A t beyond the largest f32 becomes infinity, so use
/// [`Hit32::is_hit`] to tell hits from misses.
///
/// ```
/// use intertri::Hit32;
/// let bytes: [u8; 20] = bytemuck::cast(Hit32::MISS);
/// assert!(!bytemuck::cast::<_, Hit32>(bytes).is_hit());
/// ```
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct Hit32 {
    /// Distance along the ray in multiples of `|dir|`; infinity for a miss.
    pub t: f32,
    /// The weight of the second corner.
    pub u: f32,
    /// The weight of the third corner.
    pub v: f32,
    /// The index of the triangle, or [`Hit::NO_TRIANGLE`].
    pub triangle: u32,
    /// The index of the mesh in a hierarchy over several meshes; otherwise 0.
    pub geometry: u32,
}

const _: () = assert!(size_of::<Hit32>() == 20);

impl Hit32 {
    /// The result in a batch for a ray that hits nothing.
    pub const MISS: Self =
        Self { t: f32::INFINITY, u: 0.0, v: 0.0, triangle: Hit::NO_TRIANGLE, geometry: 0 };

    /// Returns whether this is a hit.
    #[inline]
    pub fn is_hit(&self) -> bool {
        self.triangle != Hit::NO_TRIANGLE
    }

    /// Creates a hit with the given t, u, and v.
    #[inline(always)]
    pub(crate) fn new([t, u, v]: [f32; 3], triangle: u32) -> Self {
        Self { t, u, v, triangle, geometry: 0 }
    }
}

impl From<Hit> for Hit32 {
    /// Rounds t, u, and v a second time, to f32.
    #[inline(always)]
    fn from(Hit { t, u, v, triangle, geometry }: Hit) -> Self {
        Self { t: t as f32, u: u as f32, v: v as f32, triangle, geometry }
    }
}
