//! Where rays from one origin meet the triangles that they are known to hit, given in f64: each number the exact one
//! rounded once, from what depends on the triangle and the origin, computed once.
//!
//! Bounds and proof: `docs/numerics/f64.md`, section 3.

use alloc::vec::Vec;
use core::slice;

use super::attributes;
use super::double::{Double, dot};
use super::input::{is_plain, subnormals_are_read};
use super::rounded::{Volume, quotient};
use super::tails::{DOUBT, TwoParts, cross_tails, difference, is_tame_quotient, times};
use crate::simd::{Lanes, Level, Mask, Simd, Vec3, WithSimd, by_triangle, prefetch};
use crate::{Hit, Ray64, RayOf, Triangle64};

/// The memory of a hit is prefetched so many hits before it is written.
const AHEAD: usize = 40;

/// A triangle as it is seen from one origin, ready to tell where a ray from there meets it, exactly but for one
/// rounding.
#[derive(Clone, Copy, Debug, Default)]
#[repr(C, align(64))]
pub struct HitCoefficients64 {
    /// By part and axis, the coefficients of the denominator, of the numerators of u and v, and of the
    /// denominator again.
    coefficients: [[[f64; 4]; 3]; 2],
    /// By part, the numerator of t.
    known: [[f64; 4]; 2],
    /// What the products may be off by, over the sum of a direction's sizes; NaN where nothing is proven.
    share: [f64; 4],
    /// What the numerator of t may be off by.
    known_err: f64,
}

/// The hits of rays from one origin: `slots[i]` is the number of the triangle that the i-th ray is known to hit, with
/// its index; beyond all of them, where it hits none.
#[inline]
pub fn hits_of_origin64(
    level: Level,
    rays: &[Ray64],
    triangles: &[(&Triangle64, u32)],
    slots: &[u32],
    scratch: &mut Vec<[HitCoefficients64; 8]>,
    hits: &mut [Hit],
) {
    level.run(OfOrigin { rays, triangles, slots, scratch, hits });
}

struct OfOrigin<'a> {
    rays: &'a [Ray64],
    triangles: &'a [(&'a Triangle64, u32)],
    slots: &'a [u32],
    scratch: &'a mut Vec<[HitCoefficients64; 8]>,
    hits: &'a mut [Hit],
}

impl WithSimd for OfOrigin<'_> {
    type Output = ();

    #[inline(always)]
    fn run<S: Simd>(self) {
        let Self { rays, triangles, slots, scratch, hits } = self;
        let Some(first) = rays.first() else { return };
        let needed = triangles.len().div_ceil(8);
        if scratch.len() < needed {
            scratch.resize(needed, Default::default());
        }
        for (i, (some, to)) in triangles.chunks(8).zip(&mut *scratch).enumerate() {
            for (triangle, _) in triangles.iter().skip(8 * i + 8).take(8) {
                prefetch(slice::from_ref(*triangle));
            }
            eight::<S>(some, first.origin, to);
        }
        let coefficients = scratch.as_flattened();
        for (i, (ray, &slot)) in rays.iter().zip(slots).enumerate() {
            if let Some(later) = hits.get(i + AHEAD) {
                prefetch(slice::from_ref(later));
            }
            let hit = &mut hits[i];
            let Some(&(triangle, index)) = triangles.get(slot as usize) else {
                *hit = Hit::MISS;
                continue;
            };
            let sure = coefficients[slot as usize].hit_in::<S>(ray, hit);
            if !sure {
                (hit.t, hit.u, hit.v) = attributes(ray, triangle);
            }
            (hit.triangle, hit.geometry) = (index, 0);
        }
    }
}

/// Eight triangles, or fewer.
#[inline(always)]
fn eight<S: Simd>(
    triangles: &[(&Triangle64, u32)],
    origin: [f64; 3],
    to: &mut [HitCoefficients64; 8],
) {
    let (mut numbers, mut plain) = ([[[0.0; 8]; 3]; 3], 0);
    let ray = RayOf::new(origin, [1.0; 3]);
    for (lane, (triangle, _)) in triangles.iter().enumerate() {
        for (to, from) in numbers.iter_mut().zip(&triangle.0) {
            (to[0][lane], to[1][lane], to[2][lane]) = (from[0], from[1], from[2]);
        }
        plain |= u32::from(is_plain(&ray, triangle)) << lane;
    }
    let plain = if subnormals_are_read() { plain } else { 0 };
    let [c1, c2, c3] = &numbers;
    let [c1, c2, c3] = [Vec3::<S::F64x8>::load(c1), Vec3::load(c2), Vec3::load(c3)];
    let (a, h4, h5) = (difference(c1, Vec3::splat(origin)), difference(c2, c1), difference(c3, c1));
    let (n, v, w) = (cross_tails(&h4, &h5), cross_tails(&h5, &a), cross_tails(&a, &h4));

    // What each may be off by.
    let plain = Mask::from_bits(plain);
    let of_n = share(&h4, &h5, plain);
    let shares = by_triangle::<S>([of_n, share(&h5, &a, plain), share(&a, &h4, plain), of_n]);
    let num = times(&n, &a);
    let num_err = h4.first.abs().permanents(h5.first.abs()).dot_fused(a.first.abs());
    let num_err = num_err * Lanes::splat(DOUBT);

    let mut known = [[0.0; 8]; 3];
    num.high.store(&mut known[0]);
    num.low.store(&mut known[1]);
    num_err.store(&mut known[2]);
    for axis in 0..3 {
        let high = [n[axis].high, v[axis].high, w[axis].high, n[axis].high];
        let low = [n[axis].low, v[axis].low, w[axis].low, n[axis].low];
        for (half, rows) in [by_triangle::<S>(high), by_triangle::<S>(low)].iter().enumerate() {
            for (i, seen) in to.iter_mut().enumerate() {
                rows[i / 4][i % 4].store(&mut seen.coefficients[half][axis]);
            }
        }
    }
    for (i, seen) in to.iter_mut().enumerate() {
        shares[i / 4][i % 4].store(&mut seen.share);
        seen.known = [[known[0][i], 0.0, 0.0, 0.0], [known[1][i], 0.0, 0.0, 0.0]];
        seen.known_err = known[2][i];
    }
}

impl HitCoefficients64 {
    /// Where a ray meets the triangle, but for the index; whether that is proven.
    #[inline(always)]
    fn hit_in<S: Simd>(&self, ray: &Ray64, to: &mut Hit) -> bool {
        let dir = ray.dir;
        let [high, low] = &self.coefficients;
        let part = |axis: usize| Double {
            high: S::F64x4::load(&high[axis]),
            low: S::F64x4::load(&low[axis]),
        };
        let sums = dot(&[part(0), part(1), part(2)], Vec3::splat(dir));
        let size = dir[0].abs() + dir[1].abs() + dir[2].abs();
        let err = <S::F64x4 as Lanes>::load(&self.share) * Lanes::splat(size);

        // All over the last; the first is t, whose numerator is known.
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
        let sure = (sure & is_tame_quotient(hit)).bits() & 0b111 == 0b111;
        let numbers: &mut [f64; 4] = bytemuck::cast_mut(to);
        hit.store(numbers);

        // The direction, and behind it the end of the interval, which does not count.
        let [.., x, y, z, t_max]: &[f64; 8] = bytemuck::cast_ref(ray);
        let size = <S::F64x4 as Lanes>::load(&[*x, *y, *z, *t_max]).abs();
        let tame = size.ge(Lanes::splat(TAME_DIR[0])) & size.le(Lanes::splat(TAME_DIR[1]));
        let tame = (tame | size.le(Lanes::splat(0.0))).bits();
        sure && tame & 0b111 == 0b111
    }
}

/// `2^-200` and `2^300`, as all that is proven takes of numbers.
const TAME_DIR: [f64; 2] = [f64::from_bits((1023 - 200) << 52), f64::from_bits((1023 + 300) << 52)];

/// What a cross product's product with a direction may be off by, over the sum of its sizes; NaN where nothing is
/// proven.
#[inline(always)]
fn share<D: Lanes<Scalar = f64>>(a: &TwoParts<D>, b: &TwoParts<D>, plain: D::Mask) -> D {
    let all = a.first.abs().permanents(b.first.abs()).norm1() * D::splat(DOUBT);
    D::select(plain, all, D::splat(f64::NAN))
}
