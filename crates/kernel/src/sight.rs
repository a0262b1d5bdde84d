//! Where rays from one origin meet the triangles that they are known to hit.
//!
//! ```text
//!   num:  nrm & a   V & dir   W & dir              what does not depend on the direction is
//!   den:  nrm & dir N & dir   N & dir              computed once for a triangle and an origin,
//!           = t       = u       = v    triangle    and a ray takes one division of four lanes
//! ```
//!
//! Document A gives t, document D the weights. The operations and their order are the reference's, so
//! t has its bits.

use crate::double::Tri;
use crate::lanes::{Lanes, Mask, Simd};
use crate::{Coefficients, Hit, Vec3};

/// A triangle as it is seen from one origin, ready to tell where a ray from there meets it.
///
/// ```
/// use intertri::lanes::{Simd, WithSimd, dispatch};
/// use intertri::{Certified, Hit, Mode, Ray, Sight, Triangle, TrianglePack};
///
/// struct Meet<'a>(&'a TrianglePack<8>, &'a Ray);
/// impl WithSimd for Meet<'_> {
///     type Output = Hit;
///     #[inline(always)]
///     fn run<S: Simd>(self) -> Hit {
///         let sights = Sight::eight_in::<S>(self.0.corners(), &[0; 8], self.1.origin);
///         let mut hit = Hit::MISS;
///         sights[3].hit_in::<S>(self.1.dir, &mut hit);
///         hit
///     }
/// }
///
/// let at = |z| Triangle::new([0.0, 0.0, z], [1.0, 0.0, z], [0.0, 1.0, z]);
/// let (eight, ray) = ([at(5.0); 8], Ray::new([0.25, 0.5, 0.0], [-0.05, 0.0, 2.0]));
/// let hit = dispatch(Meet(&TrianglePack::new(&eight), &ray));
/// assert_eq!(hit, Certified::default().closest(&eight, &ray));
/// ```
#[derive(Clone, Copy, Debug)]
#[repr(C, align(32))]
pub struct Sight {
    /// By axis, the coefficients of the denominators of t, u and v.
    den: [[f64; 4]; 3],
    /// By axis, those of the numerators of u and v.
    num: [[f64; 4]; 3],
    /// The numerator of t, and the triangle's index as bits.
    known: [f64; 4],
}

impl Sight {
    /// Eight triangles: `corners[k][axis][lane]` is of corner k+1.
    #[inline(always)]
    pub fn eight_in<S: Simd>(
        [c1, c2, c3]: &[[[f32; 8]; 3]; 3],
        indices: &[u32; 8],
        origin: [f32; 3],
    ) -> [Self; 8] {
        let corners = [Vec3::load_f32(c1), Vec3::load_f32(c2), Vec3::load_f32(c3)];
        let tri = Tri::new(corners);
        let [x, y, z] = origin;
        let origin = Vec3::<S::F64x8>::splat([x.into(), y.into(), z.into()]);
        let Coefficients { a, n, v, w, .. } = Coefficients::of(corners, origin);
        let zero = [[0.0; 8]; 3];
        let (mut nrm, mut den, mut num) = (zero, zero, [zero; 2]);
        let mut at = [0.0; 8];
        tri.nrm.dot(a).store(&mut at);
        tri.nrm.store(&mut nrm);
        n.store(&mut den);
        v.store(&mut num[0]);
        w.store(&mut num[1]);

        let none = Self { den: [[1.0; 4]; 3], num: [[0.0; 4]; 3], known: [0.0; 4] };
        let mut sights = [none; 8];
        for (i, sight) in sights.iter_mut().enumerate() {
            for k in 0..3 {
                let n = den[k][i];
                sight.den[k] = [nrm[k][i], n, n, 1.0];
                sight.num[k] = [0.0, num[0][k][i], num[1][k][i], 0.0];
            }
            sight.known = [at[i], 0.0, 0.0, f64::from_bits(indices[i].into())];
        }
        sights
    }

    /// Where a ray that is known to hit the triangle meets it.
    #[inline(always)]
    pub fn hit_in<S: Simd>(&self, dir: [f32; 3], to: &mut Hit) {
        let dir = Vec3::<S::F64x4>::splat([dir[0].into(), dir[1].into(), dir[2].into()]);
        let lane = |i: u32| <S::F64x4 as Lanes>::Mask::from_bits(1 << i);
        let known = S::F64x4::load(&self.known);
        let num = S::F64x4::select(lane(0), known, Vec3::load(&self.num).dot(dir));
        let hit = num / Vec3::load(&self.den).dot(dir);
        let to: &mut [f64; 4] = bytemuck::cast_mut(to);
        S::F64x4::select(lane(3), known, hit).store(to);
    }
}
