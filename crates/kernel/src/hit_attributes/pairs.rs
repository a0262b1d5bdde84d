//! Computes t, u, and v for eight pairs in lanes, each a ray and a triangle that it is known to
//! hit.
//!
//! The operations and their order match the reference implementation, so every t matches it bit for
//! bit. The weights follow document D.

use crate::barycentric::Coefficients;
use crate::document::Tri;
use crate::simd::Vec3;
use crate::simd::{Lanes, Simd};
use crate::{Hit, Ray, RayOf, Scalar, Triangle, TriangleId, TriangleOf};

/// Up to eight rays, each with a triangle that it is known to hit, for use in a loop that is
/// compiled for an instruction level.
///
/// ```
/// use intertri::internal::Pairs;
/// use intertri::simd::{Simd, WithSimd, dispatch};
/// use intertri::{Hit, Ray, Triangle, TriangleId};
///
/// struct Meet;
/// impl WithSimd for Meet {
///     type Output = [Hit; 8];
///     #[inline(always)]
///     fn run<S: Simd>(self) -> [Hit; 8] {
///         let triangle = Triangle::new([0.0, 0.0, 5.0], [1.0, 0.0, 5.0], [0.0, 1.0, 5.0]);
///         let mut pairs = Pairs::new();
///         pairs.set(0, &Ray::new([0.25, 0.5, 0.0], [0.0, 0.0, 2.0]), &triangle, TriangleId(7));
///         pairs.hits_in::<S>()
///     }
/// }
/// assert_eq!(dispatch(Meet)[0], Hit { t: 2.5, u: 0.25, v: 0.5, triangle: 7, geometry: 0 });
/// ```
#[derive(Clone, Debug)]
pub struct Pairs {
    corners: [[[f32; 8]; 3]; 3],
    origin: [[f32; 8]; 3],
    dir: [[f32; 8]; 3],
    index: [u32; 8],
}

impl Default for Pairs {
    fn default() -> Self {
        Self::new()
    }
}

impl Pairs {
    /// Creates an empty set of pairs.
    pub fn new() -> Self {
        let zero = [[0.0; 8]; 3];
        Self { corners: [zero; 3], origin: zero, dir: zero, index: [0; 8] }
    }

    /// Stores a ray and its triangle in one of the eight lanes.
    #[inline(always)]
    pub fn set(&mut self, lane: usize, ray: &Ray, triangle: &Triangle, id: TriangleId) {
        for axis in 0..3 {
            for corner in 0..3 {
                self.corners[corner][axis][lane] = triangle.0[corner][axis];
            }
            self.origin[axis][lane] = ray.origin[axis];
            self.dir[axis][lane] = ray.dir[axis];
        }
        self.index[lane] = id.0;
    }

    /// Returns the ray and the triangle in a lane, and the triangle's index.
    #[inline]
    pub fn pair(&self, lane: usize) -> (Ray, Triangle, TriangleId) {
        let vec3 = |rows: &[[f32; 8]; 3]| rows.each_ref().map(|row| row[lane]);
        let ray = Ray::new(vec3(&self.origin), vec3(&self.dir));
        (ray, Triangle(self.corners.each_ref().map(vec3)), TriangleId(self.index[lane]))
    }

    /// Returns the index of the triangle in a lane.
    #[inline(always)]
    pub(crate) fn index(&self, lane: usize) -> u32 {
        self.index[lane]
    }

    /// Returns the indices of the triangles in the lanes starting at `from`, as the bits of f32
    /// values.
    #[inline(always)]
    pub(crate) fn indices(&self, from: usize) -> &[f32] {
        &bytemuck::cast_ref::<[u32; 8], [f32; 8]>(&self.index)[from..]
    }

    /// Returns the corners, origins, and directions of the lanes starting at `from`.
    #[inline(always)]
    pub(crate) fn lanes<D: Lanes<Scalar = f64>>(
        &self,
        from: usize,
    ) -> ([Vec3<D>; 3], Vec3<D>, Vec3<D>) {
        let [c1, c2, c3] = &self.corners;
        let corners = [some(c1, from), some(c2, from), some(c3, from)];
        (corners, some(&self.origin, from), some(&self.dir, from))
    }

    /// Computes the hits of all lanes with the document's operations. The hits of lanes that were
    /// not set are meaningless.
    #[inline(always)]
    pub fn hits_in<S: Simd>(&self) -> [Hit; 8] {
        // Process four pairs at a time, because some CPUs lower their clock rate for even a single
        // eight-lane division.
        let (mut t, mut u, mut v) = ([0.0; 8], [0.0; 8], [0.0; 8]);
        for from in [0, 4] {
            let (corners, origin, dir) = self.lanes::<S::F64x4>(from);
            let [in_t, in_u, in_v] = crossing(corners, origin, dir);
            in_t.store(&mut t[from..]);
            in_u.store(&mut u[from..]);
            in_v.store(&mut v[from..]);
        }

        self.hits(&t, &u, &v)
    }

    /// Combines the values of all lanes into hits.
    #[inline(always)]
    pub(crate) fn hits(&self, t: &[f64; 8], u: &[f64; 8], v: &[f64; 8]) -> [Hit; 8] {
        core::array::from_fn(|lane| {
            let triangle = self.index[lane];
            Hit { t: t[lane], u: u[lane], v: v[lane], triangle, geometry: 0 }
        })
    }
}

/// Loads the lanes starting at `from`.
#[inline(always)]
fn some<D: Lanes<Scalar = f64>>(rows: &[[f32; 8]; 3], from: usize) -> Vec3<D> {
    let [x, y, z] = rows;
    Vec3 { x: D::load_f32(&x[from..]), y: D::load_f32(&y[from..]), z: D::load_f32(&z[from..]) }
}

/// Computes the document's t for triangles that are known to be hit, and the weights of their
/// second and third corners.
#[inline(always)]
fn crossing<D: Lanes<Scalar = f64>>(
    corners: [Vec3<D>; 3],
    origin: Vec3<D>,
    dir: Vec3<D>,
) -> [D; 3] {
    let t = Tri::new(corners).t(origin, dir);
    let seen = Coefficients::of(corners, origin);
    // The document's t uses a unit normal, whereas the weights use a normal of any length, so there
    // are two denominators.
    let den = seen.n.dot(dir);
    [t, seen.v.dot(dir) / den, seen.w.dot(dir) / den]
}

/// Like [`Pairs::hits_in`], but for one pair.
#[inline(always)]
pub(crate) fn of_pair<S: Scalar>(
    ray: &RayOf<S>,
    triangle: &TriangleOf<S>,
    TriangleId(index): TriangleId,
) -> Hit {
    let [c1, c2, c3] = triangle.0;
    let vec3 = |[x, y, z]: [S; 3]| Vec3::<f64>::splat([x.into(), y.into(), z.into()]);
    let corners = [vec3(c1), vec3(c2), vec3(c3)];
    let [t, u, v] = crossing(corners, vec3(ray.origin), vec3(ray.dir));
    Hit { t, u, v, triangle: index, geometry: 0 }
}
