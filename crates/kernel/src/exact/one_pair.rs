//! Where one ray meets one triangle that it is known to hit: its four volumes side by side.
//!
//! ```text
//!   D = d·(h4 × h5)    T = a·(h4 × h5)    V = h5·(a × d)    W = -h4·(a × d)       each lane x·(y × z)
//!         1                  t                  u                 v               each over D
//! ```
//!
//! A call of its own, so it asks for the instructions of a level itself: without a fused operation, what a product
//! lacks takes sixteen others.

use super::double::{Double, cross, difference};
use super::rounded::{Volume, quotient};
use crate::simd::{Lanes, Level, Mask, Simd, Vec3, WithSimd};
use crate::{RayOf, Scalar, TriangleOf};

/// t, u and v, and which of the three are proven to be rounded right, the lowest bit t's. No number may be subnormal.
pub(super) fn meet<S: Scalar>(ray: &RayOf<S>, triangle: &TriangleOf<S>) -> ([f64; 3], u32) {
    // Four lanes are all that it takes.
    Level::avx2().unwrap_or(Level::PORTABLE).run(Meet { ray, triangle })
}

struct Meet<'a, X> {
    ray: &'a RayOf<X>,
    triangle: &'a TriangleOf<X>,
}

impl<X: Scalar> WithSimd for Meet<'_, X> {
    type Output = ([f64; 3], u32);

    #[inline(always)]
    fn run<S: Simd>(self) -> Self::Output {
        let ([c1, c2, c3], o, d) = (self.triangle.0, self.ray.origin, self.ray.dir);
        let (ends, starts) = (lanes::<S, X>([c1, c2, c3, c1]), lanes::<S, X>([o, c1, c1, c1]));
        let (edges, lack) = difference(ends, starts);
        let is_exact = lack.le(Lanes::splat(0.0)).bits() & 0b111 == 0b111;

        // By lane, x·(y × z).
        let (mut x, mut y, mut z) = ([0.0; 4], [0.0; 4], [0.0; 4]);
        edges.x.store(&mut x);
        edges.y.store(&mut y);
        edges.z.store(&mut z);
        let [dx, dy, dz] = d.map(Into::<f64>::into);
        let factors = [[x, [dx; 4]], [y, [dy; 4]], [z, [dz; 4]]].map(|[e, [d, ..]]| {
            // a, h4 and h5 along an axis.
            let [a, h4, h5, _] = e;
            [[d, a, h5, -h4], [h4, h4, a, a], [h5, h5, d, d]]
        });
        let [x, y, z] = [axes::<S>(&factors, 0), axes::<S>(&factors, 1), axes::<S>(&factors, 2)];
        let volume = Volume::new(x, &cross(y, z), y, z);

        // All over the first.
        let den = Volume {
            value: Double {
                high: first::<S>(volume.value.high),
                low: first::<S>(volume.value.low),
            },
            err: first::<S>(volume.err),
        };
        let inverse = <S::F64x4 as Lanes>::splat(1.0) / den.value.high;
        let (quotients, sure) = quotient(&volume, &den, inverse);
        let mut all = [0.0; 4];
        quotients.store(&mut all);
        let [_, t, u, v] = all;
        ([t, u, v], if is_exact { sure.bits() >> 1 } else { 0 })
    }
}

/// Four vectors side by side.
#[inline(always)]
fn lanes<S: Simd, X: Scalar>(v: [[X; 3]; 4]) -> Vec3<S::F64x4> {
    let [[ax, ay, az], [bx, by, bz], [cx, cy, cz], [dx, dy, dz]] = v;
    let (x, y, z) = ([ax, bx, cx, dx], [ay, by, cy, dy], [az, bz, cz, dz]);
    let [x, y, z] = [x, y, z].map(|row| row.map(Into::<f64>::into));
    Vec3 { x: Lanes::load(&x), y: Lanes::load(&y), z: Lanes::load(&z) }
}

/// One of three factors, by axis.
#[inline(always)]
fn axes<S: Simd>([x, y, z]: &[[[f64; 4]; 3]; 3], factor: usize) -> Vec3<S::F64x4> {
    let load = [&x[factor], &y[factor], &z[factor]];
    Vec3 { x: Lanes::load(load[0]), y: Lanes::load(load[1]), z: Lanes::load(load[2]) }
}

/// The first lane in all.
#[inline(always)]
fn first<S: Simd>(of: S::F64x4) -> S::F64x4 {
    let mut all = [0.0; 4];
    of.store(&mut all);
    Lanes::splat(all[0])
}
