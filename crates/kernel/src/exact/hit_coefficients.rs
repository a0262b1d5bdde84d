//! The intersections of rays from one origin with triangles that the rays are known to hit, with
//! each value correctly rounded.
//!
//! ```text
//!   num:  n · a   v · dir   w · dir              All are two-part numbers. Values that do not
//!   den:  n · dir n · dir   n · dir              depend on the direction are computed once for a
//!           = t     = u       = v    triangle    triangle and an origin.
//! ```
//!
//! `docs/numerics/exact.md`, section 9, has the bounds and the proof.

use super::double::{Double, cross, difference, short_sum, sum};
use super::input::subnormals_are_read;
use super::rounded::{Volume, quotient};
use crate::hit_attributes::SharedHit;
use crate::simd::{Lanes, Mask, Simd, Vec3, by_triangle, put_by_triangle};
use crate::{Hit, Ray};

/// A triangle relative to one origin, prepared to compute correctly rounded hits of rays from that
/// origin. The coordinates are f32, or f64 (`shared_origin64.rs`).
///
/// ```
/// use intertri::internal::SharedHit;
/// use intertri::internal::exact::{self, HitCoefficients};
/// use intertri::simd::{Simd, WithSimd, dispatch};
/// use intertri::{Hit, Ray, Triangle, TriangleBlock};
///
/// struct Meet<'a>(&'a TriangleBlock<8>, &'a Ray);
/// impl WithSimd for Meet<'_> {
///     type Output = (Hit, bool);
///     #[inline(always)]
///     fn run<S: Simd>(self) -> Self::Output {
///         let (mut coefficients, mut hit) = ([HitCoefficients::default(); 8], Hit::MISS);
///         let Self(block, ray) = self;
///         HitCoefficients::eight_in::<S>(block.corners(), &[7; 8], ray, &mut coefficients);
///         let sure = coefficients[3].hit_in::<S>(ray, &mut hit);
///         (hit, sure)
///     }
/// }
///
/// let wall = Triangle::new([0.0, 0.0, 5.0], [1.0, 0.0, 5.5], [0.0, 1.0, 5.0]);
/// let ray = Ray::new([0.25, 0.5, 0.0], [-0.05, 0.1, 2.0]);
/// let (hit, sure) = dispatch(Meet(&TriangleBlock::new(&[wall; 8]), &ray));
/// assert_eq!((hit.t, hit.u, hit.v), exact::attributes(&ray, &wall));
/// assert!(sure && hit.triangle == 7);
/// ```
#[derive(Clone, Copy, Debug, Default)]
#[repr(C, align(64))]
pub struct HitCoefficients {
    /// The coefficients of the denominator, of the numerators of u and v, and of the denominator
    /// again, by part and axis.
    coefficients: [[[f64; 4]; 3]; 2],
    /// The numerator of t, by part.
    known: [[f64; 4]; 2],
    /// The error bounds on the products, divided by the sum of the magnitudes of the direction's
    /// components. They are NaN if nothing is proven.
    share: [f64; 4],
    /// The error bound on the numerator of t.
    known_err: f64,
    index: u32,
}

/// Eight triangles relative to one origin, in lanes.
pub(super) struct EightSeen<D: Lanes> {
    /// The cross products n, v and w, each in two parts.
    pub(super) products: [[Vec3<D>; 2]; 3],
    /// The error bounds on the products of n, v and w with a direction, divided by the sum of the
    /// magnitudes of its components. They are NaN if nothing is proven.
    pub(super) shares: [D; 3],
    /// The numerator of t.
    pub(super) num: Volume<D>,
}

impl<D: Lanes<Scalar = f64>> EightSeen<D> {
    /// Stores the values of each triangle together.
    #[inline(always)]
    pub(super) fn put<S: Simd<F64x8 = D>>(
        &self,
        indices: &[u32; 8],
        to: &mut [HitCoefficients; 8],
    ) {
        let ([n, v, w], [of_n, of_v, of_w]) = (&self.products, self.shares);
        for half in [0, 1] {
            let products = [n[half], v[half], w[half], n[half]];
            put_by_triangle::<S>(products, to.iter_mut().map(|seen| &mut seen.coefficients[half]));
        }
        let shares = by_triangle::<S>([of_n, of_v, of_w, of_n]);
        let mut known = [[0.0; 8]; 3];
        self.num.value.high.store(&mut known[0]);
        self.num.value.low.store(&mut known[1]);
        self.num.err.store(&mut known[2]);
        for (i, seen) in to.iter_mut().enumerate() {
            shares[i / 4][i % 4].store(&mut seen.share);
            seen.known = [[known[0][i], 0.0, 0.0, 0.0], [known[1][i], 0.0, 0.0, 0.0]];
            (seen.known_err, seen.index) = (known[2][i], indices[i]);
        }
    }
}

impl HitCoefficients {
    /// Returns the coefficients, by part.
    #[inline(always)]
    pub(super) fn parts<S: Simd>(&self) -> [Vec3<S::F64x4>; 2] {
        let [high, low] = &self.coefficients;
        [Vec3::load(high), Vec3::load(low)]
    }

    /// Computes t, u and v of the hit, and which of them are proven. `sums` are the products of the
    /// coefficients with the ray's direction, and `size` is the sum of the magnitudes of the
    /// direction's components.
    #[inline(always)]
    pub(super) fn meet<S: Simd>(
        &self,
        sums: &Double<S::F64x4>,
        size: f64,
        to: &mut Hit,
    ) -> (S::F64x4, <S::F64x4 as Lanes>::Mask) {
        let err = <S::F64x4 as Lanes>::load(&self.share) * Lanes::splat(size);

        // Lane 0 becomes t, and lanes 1 and 2 become u and v. The sums in lanes 0 and 3 are both D.
        // The numerator of t does not depend on the direction and is already known, so lane 0 can
        // hold the denominator of t, and lane 3 that of u and v.
        let den = Volume {
            value: Double { high: S::first_and_last(sums.high), low: S::first_and_last(sums.low) },
            err: S::first_and_last(err),
        };
        let first = <S::F64x4 as Lanes>::Mask::from_bits(1);
        let [high, low] = &self.known;
        let num = Volume {
            value: Double {
                high: Lanes::select(first, S::F64x4::load(high), sums.high),
                low: Lanes::select(first, S::F64x4::load(low), sums.low),
            },
            err: Lanes::select(first, Lanes::splat(self.known_err), err),
        };
        let (hit, sure) = quotient(&num, &den, <S::F64x4 as Lanes>::splat(1.0) / den.value.high);
        let numbers: &mut [f64; 4] = bytemuck::cast_mut(to);
        hit.store(numbers);
        (to.triangle, to.geometry) = (self.index, 0);
        (hit, sure)
    }
}

impl SharedHit for HitCoefficients {
    #[inline(always)]
    fn eight_in<S: Simd>(
        [c1, c2, c3]: &[[[f32; 8]; 3]; 3],
        indices: &[u32; 8],
        ray: &Ray,
        to: &mut [Self; 8],
    ) {
        let corners = [Vec3::<S::F64x8>::load_f32(c1), Vec3::load_f32(c2), Vec3::load_f32(c3)];
        let [c1, c2, c3] = corners;
        let origin = Vec3::splat_f32(ray.origin);
        let ((a, x), (h4, y), (h5, z)) =
            (difference(c1, origin), difference(c2, c1), difference(c3, c1));
        let (n, v, w) = (cross(h4, h5), cross(h5, a), cross(a, h4));

        // Compute the error bounds. If a difference is not exact, nothing is proven.
        let exact = (x + y + z).le(Lanes::splat(0.0));
        let exact = if subnormals_are_read() { exact } else { Mask::from_bits(0) };
        let seen = EightSeen {
            products: [halves(&n), halves(&v), halves(&w)],
            shares: [share(h4, h5, exact), share(h5, a, exact), share(a, h4, exact)],
            num: Volume::new(a, &n, h4, h5),
        };
        seen.put::<S>(indices, to);
    }

    #[inline(always)]
    fn hit_in<S: Simd>(&self, ray: &Ray, to: &mut Hit) -> bool {
        let [x, y, z] = ray.dir;
        let dir = Vec3::<S::F64x4>::splat_f32(ray.dir);
        let sums = product(self.parts::<S>(), dir);
        let size = f64::from(x.abs()) + f64::from(y.abs()) + f64::from(z.abs());
        let (_, sure) = self.meet::<S>(&sums, size, to);
        sure.bits() & 0b111 == 0b111
    }
}

/// `2^-76`: the error of the dot product of a split cross product and a direction is at most half
/// this value times the permanent.
const SHARE: f64 = 1.0 / (1_u128 << 76) as f64;

/// Splits a vector into two parts. The first has 29 digits, so that its products with an f32 are
/// exact.
#[inline(always)]
fn halves<D: Lanes<Scalar = f64>>([x, y, z]: &[Double<D>; 3]) -> [Vec3<D>; 2] {
    let ([a, d], [b, e], [c, f]) = (split(x), split(y), split(z));
    [Vec3 { x: a, y: b, z: c }, Vec3 { x: d, y: e, z: f }]
}

#[inline(always)]
fn split<D: Lanes<Scalar = f64>>(x: &Double<D>) -> [D; 2] {
    // Veltkamp's splitting: by - (by - x) is x rounded to 53 - 24 digits.
    let by = x.high * D::splat(((1 << 24) + 1) as f64);
    let high = by - (by - x.high);
    [high, (x.high - high) + x.low]
}

/// Returns the dot product of a split vector and an f32 direction.
#[inline(always)]
fn product<D: Lanes<Scalar = f64>>([high, low]: [Vec3<D>; 2], dir: Vec3<D>) -> Double<D> {
    // A product of numbers with 29 and 24 digits fits in f64, so these products are exact, and
    // their two-part sums lose nothing.
    let xy = sum(high.x * dir.x, high.y * dir.y);
    let all = sum(xy.high, high.z * dir.z);
    short_sum(all.high, low.dot_fused(dir) + (xy.low + all.low))
}

/// Returns the error bound on the dot product of a cross product and a direction, divided by the
/// sum of the magnitudes of the direction's components. It is NaN if the vectors are not exact.
/// This is not a closure, because a closure would be compiled without the level's instructions.
#[inline(always)]
fn share<D: Lanes<Scalar = f64>>(a: Vec3<D>, b: Vec3<D>, exact: D::Mask) -> D {
    let all = a.abs().permanents(b.abs()).norm1() * D::splat(SHARE);
    D::select(exact, all, D::splat(f64::NAN))
}
