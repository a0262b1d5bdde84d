//! Computes hit attributes for f64 rays with a common origin and triangles that they are known to
//! hit. The attributes are correctly rounded. Values that depend only on the triangle and the
//! origin are computed once.
//!
//! `docs/numerics/f64.md`, section 3, has the bounds and the proof.

use alloc::vec::Vec;
use core::slice;

use super::attributes;
use super::double::{dot, parts, whole};
use super::hit_coefficients::{EightSeen, HitCoefficients};
use super::input::{is_plain, subnormals_are_read};
use super::rounded::Volume;
use super::tails::{DOUBT, TwoParts, cross_tails, difference, is_tame_quotient, times};
use crate::simd::{Lanes, Level, Mask, Simd, Vec3, WithSimd, prefetch};
use crate::{Hit, Ray64, RayOf, Triangle64};

/// The distance, in hits, between the hit being written and the hit being prefetched.
const AHEAD: usize = 40;

/// Computes the hits of rays with a common origin. Each pair is a ray's index and the position in
/// `triangles` of a triangle that the ray is known to hit; an out-of-bounds position yields a miss.
#[inline]
pub fn hits_of_origin64(
    level: Level,
    rays: &[Ray64],
    triangles: &[(&Triangle64, u32)],
    pairs: &[(u32, u32)],
    scratch: &mut Vec<[HitCoefficients; 8]>,
    hits: &mut [Hit],
) {
    level.run(HitsOfOrigin { rays, triangles, pairs, scratch, hits });
}

struct HitsOfOrigin<'a> {
    rays: &'a [Ray64],
    triangles: &'a [(&'a Triangle64, u32)],
    pairs: &'a [(u32, u32)],
    scratch: &'a mut Vec<[HitCoefficients; 8]>,
    hits: &'a mut [Hit],
}

impl WithSimd for HitsOfOrigin<'_> {
    type Output = ();

    #[inline(always)]
    fn run<S: Simd>(self) {
        let Self { rays, triangles, pairs, scratch, hits } = self;
        let Some(first) = rays.first() else { return };
        let needed = triangles.len().div_ceil(8);
        if scratch.len() < needed {
            scratch.resize(needed, Default::default());
        }
        for (i, (some, to)) in triangles.chunks(8).zip(&mut *scratch).enumerate() {
            // Triangles are far apart in memory, so prefetch the next eight triangles while
            // processing the current eight.
            for (triangle, _) in triangles.iter().skip(8 * i + 8).take(8) {
                prefetch(slice::from_ref(*triangle));
            }
            eight::<S>(some, first.origin, to);
        }
        let coefficients = scratch.as_flattened();
        for (i, &(ray, number)) in pairs.iter().enumerate() {
            if let Some(later) = hits.get(i + AHEAD) {
                prefetch(slice::from_ref(later));
            }
            let hit = &mut hits[i];
            let Some(&(triangle, _)) = triangles.get(number as usize) else {
                *hit = Hit::MISS;
                continue;
            };
            let ray = &rays[ray as usize];
            let sure = coefficients[number as usize].hit64_in::<S>(ray, hit);
            if !sure {
                (hit.t, hit.u, hit.v) = attributes(ray, triangle);
            }
        }
    }
}

/// Computes the coefficients of up to eight triangles.
#[inline(always)]
fn eight<S: Simd>(
    triangles: &[(&Triangle64, u32)],
    origin: [f64; 3],
    to: &mut [HitCoefficients; 8],
) {
    let (mut numbers, mut indices, mut plain) = ([[[0.0; 8]; 3]; 3], [0; 8], 0);
    let ray = RayOf::new(origin, [1.0; 3]);
    for (lane, &(triangle, index)) in triangles.iter().enumerate() {
        indices[lane] = index;
        for (to, from) in numbers.iter_mut().zip(&triangle.0) {
            (to[0][lane], to[1][lane], to[2][lane]) = (from[0], from[1], from[2]);
        }
        plain |= u32::from(is_plain(&ray, triangle)) << lane;
    }
    let plain = if subnormals_are_read() { plain } else { 0 };
    let [c1, c2, c3] = &numbers;
    let [c1, c2, c3] = [Vec3::<S::F64x8>::load(c1), Vec3::load(c2), Vec3::load(c3)];
    let (a, h4, h5) = (difference(c1, Vec3::splat(origin)), difference(c2, c1), difference(c3, c1));
    // D, V, and W of any ray from this origin are dot products of n, h5 × A, and A × h4 with the
    // ray's direction.
    let (n, v, w) = (cross_tails(&h4, &h5), cross_tails(&h5, &a), cross_tails(&a, &h4));

    // Compute the error bounds.
    let plain = Mask::from_bits(plain);
    let num_err = h4.first.abs().permanents(h5.first.abs()).dot_fused(a.first.abs());
    let seen = EightSeen {
        products: [parts(&n), parts(&v), parts(&w)],
        shares: [share(&h4, &h5, plain), share(&h5, &a, plain), share(&a, &h4, plain)],
        num: Volume { value: times(&n, &a), err: num_err * Lanes::splat(DOUBT) },
    };
    seen.put::<S>(&indices, to);
}

impl HitCoefficients {
    /// Computes where an f64 ray meets the triangle. Returns whether the result is proven to be
    /// correctly rounded.
    #[inline(always)]
    fn hit64_in<S: Simd>(&self, ray: &Ray64, to: &mut Hit) -> bool {
        let dir = ray.dir;
        let rows = whole(self.parts::<S>());
        let sums = dot(&rows, Vec3::splat(dir));
        let size = dir[0].abs() + dir[1].abs() + dir[2].abs();
        let (hit, sure) = self.meet::<S>(&sums, size, to);
        let sure = (sure & is_tame_quotient(hit)).bits() & 0b111 == 0b111;

        // Load the direction together with the end of the interval; the lane with that end is not
        // used.
        let [.., x, y, z, t_max]: &[f64; 8] = bytemuck::cast_ref(ray);
        let size = <S::F64x4 as Lanes>::load(&[*x, *y, *z, *t_max]).abs();
        let tame = size.ge(Lanes::splat(TAME_DIR[0])) & size.le(Lanes::splat(TAME_DIR[1]));
        let tame = (tame | size.le(Lanes::splat(0.0))).bits();
        sure && tame & 0b111 == 0b111
    }
}

/// The proof covers directions in which each component is 0 or has a magnitude between these
/// limits, `2^-200` and `2^300`.
const TAME_DIR: [f64; 2] = [f64::from_bits((1023 - 200) << 52), f64::from_bits((1023 + 300) << 52)];

/// Returns the error bound on the dot product of a cross product and a direction, divided by the
/// sum of the magnitudes of the direction's components, or NaN if nothing is proven.
#[inline(always)]
fn share<D: Lanes<Scalar = f64>>(a: &TwoParts<D>, b: &TwoParts<D>, plain: D::Mask) -> D {
    let all = a.first.abs().permanents(b.first.abs()).norm1() * D::splat(DOUBT);
    D::select(plain, all, D::splat(f64::NAN))
}
