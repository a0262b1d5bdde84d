//! Computes t, u, and v for rays from one origin and triangles that they are known to hit.
//!
//! ```text
//!   num:  nrm & a   V & dir   W & dir              The coefficients are computed once for a
//!   den:  nrm & dir N & dir   N & dir              triangle and an origin. Each ray then takes
//!           = t       = u       = v    triangle    a dot product and a division in four lanes:
//!                                                  nrm, V, W, and N.
//! ```
//!
//! t follows document A, whose dot product is written `&`, and the weights follow document D. The
//! operations and their order match the reference implementation, so every t matches it bit for
//! bit.

use super::shared_hit::SharedHit;
use crate::barycentric::Coefficients;
use crate::document::Tri;
use crate::simd::Vec3;
use crate::simd::{Lanes, Mask, Simd, put_by_triangle};
use crate::{Hit, Hit32, Ray};

/// A triangle relative to an origin, with the coefficients of t, u, and v for rays from that
/// origin.
///
/// ```
/// use intertri::internal::{HitCoefficients, SharedHit};
/// use intertri::simd::{Simd, WithSimd, dispatch};
/// use intertri::{Hit, Mode, Ray, Triangle, TriangleBlock};
///
/// struct Meet<'a>(&'a TriangleBlock<8>, &'a Ray);
/// impl WithSimd for Meet<'_> {
///     type Output = Hit;
///     #[inline(always)]
///     fn run<S: Simd>(self) -> Hit {
///         let (mut coefficients, mut hit) = ([HitCoefficients::default(); 8], Hit::MISS);
///         let Self(block, ray) = self;
///         let corners = block.corners();
///         <HitCoefficients as SharedHit>::eight_in::<S>(corners, &[0; 8], ray, &mut coefficients);
///         coefficients[3].hit_in::<S>(ray, &mut hit);
///         hit
///     }
/// }
///
/// let at = |z| Triangle::new([0.0, 0.0, z], [1.0, 0.0, z], [0.0, 1.0, z]);
/// let (eight, ray) = ([at(5.0); 8], Ray::new([0.25, 0.5, 0.0], [-0.05, 0.0, 2.0]));
/// let hit = dispatch(Meet(&TriangleBlock::new(&eight), &ray));
/// assert_eq!(Some(hit), Mode::certified().closest(&eight, &ray));
/// ```
#[derive(Clone, Copy, Debug, Default)]
#[repr(C, align(64))]
pub struct HitCoefficients {
    /// For each axis, the coefficients of t's denominator, of the numerators of u and v, and of the
    /// denominator of u and v.
    coefficients: [[f64; 4]; 3],
    /// The numerator of t and, in the last element, the indices of the triangle and the geometry as
    /// bits.
    known: [f64; 4],
}

impl SharedHit for HitCoefficients {
    #[inline(always)]
    fn eight_in<S: Simd>(
        [c1, c2, c3]: &[[[f32; 8]; 3]; 3],
        indices: &[u32; 8],
        ray: &Ray,
        to: &mut [Self; 8],
    ) {
        let corners = [Vec3::load_f32(c1), Vec3::load_f32(c2), Vec3::load_f32(c3)];
        let tri = Tri::new(corners);
        let origin = Vec3::<S::F64x8>::splat_f32(ray.origin);
        let Coefficients { a, n, v, w, .. } = Coefficients::of(corners, origin);
        let vectors = [tri.nrm, v, w, n];
        put_by_triangle::<S>(vectors, to.iter_mut().map(|seen| &mut seen.coefficients));
        let mut num = [0.0; 8];
        tri.nrm.dot(a).store(&mut num);
        for (i, seen) in to.iter_mut().enumerate() {
            seen.known = [num[i], 0.0, 0.0, bytemuck::cast([indices[i], 0])];
        }
    }

    #[inline(always)]
    fn hit_in<S: Simd>(&self, ray: &Ray, to: &mut Hit) -> bool {
        let dir = Vec3::<S::F64x4>::splat_f32(ray.dir);
        // The four sums are t's denominator, the numerators of u and v, and the common denominator
        // of u and v. The numerator of t is known, so one four-lane division yields t, u, and v.
        // Lane 3 is then replaced with the indices.
        let lane = |i: u32| <S::F64x4 as Lanes>::Mask::from_bits(1 << i);
        let known = S::F64x4::load(&self.known);
        let sums = Vec3::load(&self.coefficients).dot(dir);
        let hit = S::F64x4::select(lane(0), known, sums) / S::first_and_last(sums);
        let to: &mut [f64; 4] = bytemuck::cast_mut(to);
        S::F64x4::select(lane(3), known, hit).store(to);
        true
    }
}

impl SharedHit<Hit32> for HitCoefficients {
    #[inline(always)]
    fn eight_in<S: Simd>(
        corners: &[[[f32; 8]; 3]; 3],
        indices: &[u32; 8],
        ray: &Ray,
        to: &mut [Self; 8],
    ) {
        <Self as SharedHit>::eight_in::<S>(corners, indices, ray, to);
    }

    #[inline(always)]
    fn hit_in<S: Simd>(&self, ray: &Ray, to: &mut Hit32) -> bool {
        let mut hit = Hit::MISS;
        let sure = <Self as SharedHit>::hit_in::<S>(self, ray, &mut hit);
        *to = hit.into();
        sure
    }
}
