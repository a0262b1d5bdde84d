//! Intersects one ray with the plane of one triangle. The intersection needs four volumes, each
//! computed in its own SIMD lane.
//!
//! ```text
//!   D = d·(h4 × h5)    T = A·(h4 × h5)    V = h5·(A × d)    W = -h4·(A × d)    per lane: x·(y × z)
//!         1                  t                  u                 v            divided by D
//! ```
//!
//! This code is called out of line, so it selects the instruction level itself: without a fused
//! multiply-add, computing the rounding error of a product takes sixteen operations. For f32 input,
//! the quotients are proven only if A, h4, and h5 are exact in f64. For f64 input, A, h4, and h5 are
//! stored exactly, as sums of two parts.

use super::double::{Double, cross, sum};
use super::rounded::{Volume, quotient};
use super::tails::{self, TwoParts};
use super::tier::is_f64;
use crate::simd::{Lanes, Level, Mask, Simd, Vec3, WithSimd};
use crate::{RayOf, Scalar, TriangleOf};

/// The intersection of a ray with a triangle's plane, and the side of each edge on which the ray
/// passes.
#[derive(Clone, Copy)]
pub(super) struct Intersection {
    /// t, u, and v.
    pub(super) quotients: [f64; 3],
    /// Bits 0, 1, and 2 are set if t, u, and v, respectively, are proven to be correctly rounded.
    pub(super) sure: u32,
    /// The high parts, low parts, and error bounds on D, T, V, and W. The bounds are NaN if nothing
    /// is proven.
    volumes: [[f64; 4]; 3],
}

impl Intersection {
    /// Returns the signs of T, U, V, and W, with 0 for each sign that is not proven.
    pub(super) fn signs(&self) -> [i8; 4] {
        let [high, low, err] = self.volumes;
        let [_, t, v, w] = [0, 1, 2, 3].map(|i| sign(high[i], err[i]));
        // U is D minus V and W. Compute this difference in two parts as well, because U may be
        // small even if D, V, and W are not.
        let first = sum(high[0], -high[2]);
        let rest = sum(first.high, -high[3]);
        let lows = (low[0] - low[2] - low[3]) + (first.low + rest.low);
        let u = sign(rest.high + lows, err[0] + err[2] + err[3]);
        [t, u, v, w]
    }
}

/// Returns the sign of a number with the given error bound, or 0 if the sign is uncertain.
fn sign(x: f64, err: f64) -> i8 {
    i8::from(x > err) - i8::from(x < -err)
}

/// Computes where a ray meets a triangle. The input must satisfy `input::is_plain`.
pub(super) fn meet<S: Scalar>(ray: &RayOf<S>, triangle: &TriangleOf<S>) -> Intersection {
    // Four lanes hold all four volumes, so wider registers would not help.
    Level::avx2().unwrap_or(Level::PORTABLE).run(IntersectPair { ray, triangle })
}

struct IntersectPair<'a, X> {
    ray: &'a RayOf<X>,
    triangle: &'a TriangleOf<X>,
}

impl<X: Scalar> WithSimd for IntersectPair<'_, X> {
    type Output = Intersection;

    #[inline(always)]
    fn run<S: Simd>(self) -> Self::Output {
        let ([c1, c2, c3], o, d) = (self.triangle.0, self.ray.origin, self.ray.dir);
        // One subtraction computes A, h4, and h5 in three lanes; the fourth lane is padding.
        let (ends, starts) = (lanes::<S, X>([c1, c2, c3, c1]), lanes::<S, X>([o, c1, c1, c1]));
        let edges: TwoParts<S::F64x4> = tails::difference(ends, starts);

        // Each lane computes x·(y × z).
        //    lane   1        2        3        4
        //    x      d        A        h5      -h4
        //    y      h4       h4       A        A
        //    z      h5       h5       d        d
        let [x, y, z] = factors::<S>(edges.first, d.map(Into::into));
        let permanent = y.abs().permanents(z.abs()).dot_fused(x.abs());
        let (volume, exact) = if const { is_f64::<X>() } {
            let [x_rest, y_rest, z_rest] = factors::<S>(edges.rest, [0.0; 3]);
            let (y, z) = (TwoParts { first: y, rest: y_rest }, TwoParts { first: z, rest: z_rest });
            let value =
                tails::times(&tails::cross_tails(&y, &z), &TwoParts { first: x, rest: x_rest });
            (Volume { value, err: permanent * Lanes::splat(tails::DOUBT) }, true)
        } else {
            let rest = edges.rest.abs();
            let is_exact = (rest.x + rest.y + rest.z).le(Lanes::splat(0.0)).bits();
            (Volume::new(x, &cross(y, z), y, z), is_exact & 0b111 == 0b111)
        };

        // Divide all volumes by the first, D.
        let den = Volume {
            value: Double {
                high: first::<S>(volume.value.high),
                low: first::<S>(volume.value.low),
            },
            err: first::<S>(volume.err),
        };
        let inverse = <S::F64x4 as Lanes>::splat(1.0) / den.value.high;
        let (quotients, mut sure) = quotient(&volume, &den, inverse);
        if const { is_f64::<X>() } {
            sure = sure & tails::is_tame_quotient(quotients);
        }
        let (mut all, mut volumes) = ([0.0; 4], [[0.0; 4]; 3]);
        quotients.store(&mut all);
        volume.value.high.store(&mut volumes[0]);
        volume.value.low.store(&mut volumes[1]);
        volume.err.store(&mut volumes[2]);
        let [_, t, u, v] = all;
        if !exact {
            // Set the error bounds to NaN, so that no sign counts as proven either.
            volumes[2] = [f64::NAN; 4];
        }
        Intersection {
            quotients: [t, u, v],
            sure: if exact { sure.bits() >> 1 } else { 0 },
            volumes,
        }
    }
}

/// Transposes four vectors into lanes. The code avoids an array's `map`, which may compile to a
/// call to a function that lacks the level's instructions.
#[inline(always)]
fn lanes<S: Simd, X: Scalar>([a, b, c, d]: [[X; 3]; 4]) -> Vec3<S::F64x4> {
    let x: [f64; 4] = [a[0].into(), b[0].into(), c[0].into(), d[0].into()];
    let y: [f64; 4] = [a[1].into(), b[1].into(), c[1].into(), d[1].into()];
    let z: [f64; 4] = [a[2].into(), b[2].into(), c[2].into(), d[2].into()];
    Vec3 { x: Lanes::load(&x), y: Lanes::load(&y), z: Lanes::load(&z) }
}

/// Returns the factors x, y, and z of each volume. The first three lanes of `edges` hold A, h4, and
/// h5.
#[inline(always)]
fn factors<S: Simd>(edges: Vec3<S::F64x4>, [dx, dy, dz]: [f64; 3]) -> [Vec3<S::F64x4>; 3] {
    let [x, y, z] = [axis::<S>(edges.x, dx), axis::<S>(edges.y, dy), axis::<S>(edges.z, dz)];
    [
        Vec3 { x: x[0], y: y[0], z: z[0] },
        Vec3 { x: x[1], y: y[1], z: z[1] },
        Vec3 { x: x[2], y: y[2], z: z[2] },
    ]
}

/// Returns the components of the factors along one axis.
#[inline(always)]
fn axis<S: Simd>(edges: S::F64x4, d: f64) -> [S::F64x4; 3] {
    let mut numbers = [0.0; 4];
    edges.store(&mut numbers);
    let [a, h4, h5, _] = numbers;
    [Lanes::load(&[d, a, h5, -h4]), Lanes::load(&[h4, h4, a, a]), Lanes::load(&[h5, h5, d, d])]
}

/// Copies the first lane to every lane.
#[inline(always)]
fn first<S: Simd>(of: S::F64x4) -> S::F64x4 {
    let mut all = [0.0; 4];
    of.store(&mut all);
    Lanes::splat(all[0])
}
