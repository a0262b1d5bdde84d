//! Where rays from one origin meet the triangles that they are known to hit.
//!
//! What does not depend on the direction is computed once for a triangle and an origin, eight side
//! by side: the normal and `nrm & a` of document A, the coefficients of document D. The operations
//! and their order are the reference's, so t has its bits.

use crate::double::Tri;
use crate::lanes::{Lanes, Simd};
use crate::{Coefficients, Hit, Vec3};

/// Eight triangles as they are seen from one origin, ready to tell where a ray from there meets
/// them.
///
/// ```
/// use intertri::lanes::{Simd, WithSimd, dispatch};
/// use intertri::{Certified, Mode, Ray, Sights, Triangle, TrianglePack};
///
/// struct Eight<'a>(&'a TrianglePack<8>, [f32; 3]);
/// impl WithSimd for Eight<'_> {
///     type Output = Sights;
///     #[inline(always)]
///     fn run<S: Simd>(self) -> Sights {
///         Sights::new_in::<S>(self.0.corners(), self.1)
///     }
/// }
///
/// let at = |z| Triangle::new([0.0, 0.0, z], [1.0, 0.0, z], [0.0, 1.0, z]);
/// let (eight, ray) = ([at(5.0); 8], Ray::new([0.25, 0.5, 0.0], [-0.05, 0.0, 2.0]));
/// let sights = dispatch(Eight(&TrianglePack::new(&eight), ray.origin));
/// assert_eq!(sights.hit(3, ray.dir, 7).t, Certified::default().closest(&eight, &ray).t);
/// ```
#[derive(Clone, Copy, Debug)]
pub struct Sights {
    /// The unit normals.
    nrm: [[f64; 8]; 3],
    /// Normal times way to the plane: the numerators of t.
    num: [f64; 8],
    /// The coefficients of the weights and their denominator.
    n: [[f64; 8]; 3],
    v: [[f64; 8]; 3],
    w: [[f64; 8]; 3],
}

impl Sights {
    /// What depends on the triangles and the origin: `corners[k][axis][lane]` is of corner k+1.
    #[inline(always)]
    pub fn new_in<S: Simd>([c1, c2, c3]: &[[[f32; 8]; 3]; 3], origin: [f32; 3]) -> Self {
        let corners = [Vec3::load_f32(c1), Vec3::load_f32(c2), Vec3::load_f32(c3)];
        let tri = Tri::new(corners);
        let [x, y, z] = origin;
        let origin = Vec3::<S::F64x8>::splat([x.into(), y.into(), z.into()]);
        let Coefficients { a, n, v, w, .. } = Coefficients::of(corners, origin);
        let zero = [[0.0; 8]; 3];
        let mut sights = Self { nrm: zero, num: [0.0; 8], n: zero, v: zero, w: zero };
        tri.nrm.dot(a).store(&mut sights.num);
        tri.nrm.store(&mut sights.nrm);
        n.store(&mut sights.n);
        v.store(&mut sights.v);
        w.store(&mut sights.w);
        sights
    }

    /// Where a ray that is known to hit the triangle in a lane meets it; the triangle's index is
    /// `triangle`.
    #[inline(always)]
    pub fn hit(&self, lane: usize, dir: [f32; 3], triangle: u32) -> Hit {
        let dir = Vec3::<f64>::splat([dir[0].into(), dir[1].into(), dir[2].into()]);
        let dot = |v: &[[f64; 8]; 3]| Vec3 { x: v[0][lane], y: v[1][lane], z: v[2][lane] }.dot(dir);
        let den = dot(&self.n);
        Hit {
            t: self.num[lane] / dot(&self.nrm),
            u: dot(&self.v) / den,
            v: dot(&self.w) / den,
            triangle: triangle.into(),
        }
    }
}
