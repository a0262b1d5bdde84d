//! Functions for vectors and linear forms in lanes, stored in the layout of
//! [`Outlines`](super::Outlines): three arrays of sixteen values.

use crate::simd::{Lanes, Simd, Vec3};

#[inline(always)]
pub(super) fn minus<F: Lanes>(v: Vec3<F>) -> Vec3<F> {
    Vec3 { x: -v.x, y: -v.y, z: -v.z }
}

/// Transforms vectors to other axes.
#[inline(always)]
pub(super) fn into<L: Lanes>(v: Vec3<L>, [a, b, c]: &[[L::Scalar; 3]; 3]) -> Vec3<L> {
    Vec3 {
        x: v.dot_fused(Vec3::splat(*a)),
        y: v.dot_fused(Vec3::splat(*b)),
        z: v.dot_fused(Vec3::splat(*c)),
    }
}

/// Returns the minimum and maximum of three values, extended by `room` in both directions. In lanes
/// that are not `known`, the interval is unbounded.
#[inline(always)]
pub(super) fn around<F: Lanes<Scalar = f32>>([a, b, c]: [F; 3], room: F, known: F::Mask) -> (F, F) {
    let everywhere = F::splat(f32::INFINITY);
    let lo = F::select(known, a.min(b).min(c) - room, -everywhere);
    (lo, F::select(known, a.max(b).max(c) + room, everywhere))
}

#[inline(always)]
pub(super) fn sixteen<F: Lanes<Scalar = f32>>(lanes: F) -> [f32; 16] {
    let mut numbers = [0.0; 16];
    lanes.store(&mut numbers);
    numbers
}

#[inline(always)]
pub(super) fn three<F: Lanes<Scalar = f32>>(v: Vec3<F>) -> [[f32; 16]; 3] {
    [sixteen(v.x), sixteen(v.y), sixteen(v.z)]
}

/// Loads one corner of every triangle in two blocks.
#[inline(always)]
pub(super) fn halves<S: Simd>(first: &[[f32; 8]; 3], last: &[[f32; 8]; 3]) -> Vec3<S::F32x16> {
    let ([x, y, z], [u, v, w]) = (first, last);
    Vec3 { x: S::halves(x, u), y: S::halves(y, v), z: S::halves(z, w) }
}

#[inline(always)]
pub(super) fn load<F: Lanes<Scalar = f32>>(form: &[[f32; 16]; 3]) -> [F; 3] {
    [F::load(&form[0]), F::load(&form[1]), F::load(&form[2])]
}

#[inline(always)]
pub(super) fn splat<F: Lanes<Scalar = f32>>(form: [f32; 3]) -> [F; 3] {
    [F::splat(form[0]), F::splat(form[1]), F::splat(form[2])]
}
