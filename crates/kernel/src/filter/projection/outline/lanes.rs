//! Functions for vectors and linear forms in lanes, stored in the layout of
//! [`Outlines`](super::Outlines): three arrays of sixteen values.

use super::Frame;
use crate::packet::TriangleBlock;
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
fn halves<S: Simd>(first: &[[f32; 8]; 3], last: &[[f32; 8]; 3]) -> Vec3<S::F32x16> {
    let ([x, y, z], [u, v, w]) = (first, last);
    Vec3 { x: S::halves(x, u), y: S::halves(y, v), z: S::halves(z, w) }
}

/// Returns the normals n = h4 × h5 of eight triangles and T = n · A, in f64.
#[inline(always)]
pub(super) fn planes<S: Simd>(
    block: &TriangleBlock<8>,
    frame: &Frame,
) -> (Vec3<S::F64x8>, S::F64x8) {
    let [c1, c2, c3] = block.corners();
    let c1 = Vec3::<S::F64x8>::load_f32(c1);
    let (c2, c3) = (Vec3::load_f32(c2), Vec3::load_f32(c3));
    // A block of copies contains a corner, `-h4`, and `h5`; `h5 × -h4` is `h4 × h5`.
    let n = if frame.shares.copies { c3.cross_fused(c2) } else { (c2 - c1).cross_fused(c3 - c1) };
    let [x, y, z] = frame.origin;
    (n, n.dot_fused(c1 - Vec3::splat([x.into(), y.into(), z.into()])))
}

/// Loads the corners of every triangle in two blocks, and the longest edges.
#[inline(always)]
pub(super) fn corners<S: Simd>(
    blocks: [&TriangleBlock<8>; 2],
) -> ([Vec3<S::F32x16>; 3], S::F32x16) {
    let ([a1, a2, a3], [b1, b2, b3]) = (blocks[0].corners(), blocks[1].corners());
    let corners = [halves::<S>(a1, b1), halves::<S>(a2, b2), halves::<S>(a3, b3)];
    (corners, S::halves(blocks[0].longest_edges(), blocks[1].longest_edges()))
}

#[inline(always)]
pub(super) fn load<F: Lanes<Scalar = f32>>(form: &[[f32; 16]; 3]) -> [F; 3] {
    [F::load(&form[0]), F::load(&form[1]), F::load(&form[2])]
}

#[inline(always)]
pub(super) fn splat<F: Lanes<Scalar = f32>>(form: [f32; 3]) -> [F; 3] {
    [F::splat(form[0]), F::splat(form[1]), F::splat(form[2])]
}
