//! The f32 filter: proves in f32 arithmetic that most lanes are misses.
//!
//! Integers up to 2^24 are exact in f32, and so are the differences computed here. Only products
//! are rounded; `docs/fixed-point.md` derives the error bounds, with or without fused operations.
//! Let `u = 2^-24`, and let a, h, and s be the largest components of A, of both edges, and of d.
//! Then:
//!
//! ```text
//!   |V - exact|, |W - exact| <= 30.1 u s h a      |U - exact| <= u s h (84.3 a + 36.2 h)
//! ```
//!
//! A lane with one certainly positive and one certainly negative value is a miss. The filter leaves
//! all other lanes undecided.

use super::edges::{V3, splat_f32};
use crate::simd::{Lanes, Mask};

const U: f32 = f32::EPSILON / 2.0;

/// Returns the lanes that may be hits. `s` bounds the components of the directions, `h` bounds the
/// components of the edges, and `n` is `h4 x h5`, rounded to f32.
#[inline(always)]
pub(super) fn maybe<F: Lanes<Scalar = f32>>(
    origin: V3<F>,
    d: V3<F>,
    s: F,
    [c1, h4, h5, n]: [V3<F>; 4],
    h: F,
) -> u32 {
    let a = [c1[0] - origin[0], c1[1] - origin[1], c1[2] - origin[2]];
    let r = cross(d, a);
    let minus_v = dot(h5, r);
    let w = dot(h4, r);
    let u = dot(d, n) + minus_v - w;
    let longest = a[0].abs().max(a[1].abs()).max(a[2].abs());

    // The constants are rounded up far enough to cover the rounding of this expression.
    let bound = s * h * longest.mul_add(F::splat(86.0 * U), h * F::splat(44.0 * U));
    opposite(u, -minus_v, w, bound)
}

/// Like [`maybe`], but for rays that share an origin. Takes the cross products B x C, C x A, and A
/// x B, rounded to f32. `bound` must be at least `4.1 u s (|x| + |y| + |z|)` for each cross product
/// (x, y, z).
#[inline(always)]
pub(super) fn maybe_seen<F: Lanes<Scalar = f32>>(
    d: V3<F>,
    normals: &[[f32; 3]; 3],
    bound: F,
) -> u32 {
    let u = dot(splat_f32(normals[0]), d);
    let v = dot(splat_f32(normals[1]), d);
    let w = dot(splat_f32(normals[2]), d);
    opposite(u, v, w, bound)
}

/// Returns the lanes in which no two signs are certainly opposite. If the bound is 0, the triangle
/// is a point, which no ray hits.
#[inline(always)]
fn opposite<F: Lanes<Scalar = f32>>(u: F, v: F, w: F, bound: F) -> u32 {
    let least = u.min(v).min(w);
    let most = u.max(v).max(w);
    (least.gt(-bound) | most.lt(bound)).bits()
}

/// The bound for [`maybe_seen`] is this value times `s (|x| + |y| + |z|)`, in f32.
pub(super) const SEEN: f32 = 4.5 * U;

#[inline(always)]
fn cross<F: Lanes<Scalar = f32>>(a: V3<F>, b: V3<F>) -> V3<F> {
    [
        a[1].mul_add(b[2], -(a[2] * b[1])),
        a[2].mul_add(b[0], -(a[0] * b[2])),
        a[0].mul_add(b[1], -(a[1] * b[0])),
    ]
}

#[inline(always)]
fn dot<F: Lanes<Scalar = f32>>(a: V3<F>, b: V3<F>) -> F {
    a[2].mul_add(b[2], a[1].mul_add(b[1], a[0] * b[0]))
}
