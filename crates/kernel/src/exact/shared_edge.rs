//! Tests whether a ray meets two triangles on a shared edge or corner, and thus at the same t.
//!
//! ```text
//!        P            d × P = 0           The ray goes through the corner.
//!       /|\
//!      / ● \          d·(P × Q) = 0       The ray meets the line of the edge.
//!     /  |  \
//!    ·---Q---·        P and Q are relative to the ray's origin.
//! ```
//!
//! `docs/numerics/exact.md`, section 9, has the proof.

use core::cmp::Ordering;

use super::float;
use super::input::is_plain;
use super::int::{Int, cross, dot};
use super::scale::Scale;
use super::tier::{Tier, at_tier, is_f64};
use crate::simd::Vec3;
use crate::{RayOf, Scalar, TriangleOf};

/// Returns whether a ray certainly has the same t for two triangles because it meets both on a
/// shared edge or corner. The ray's line must meet each plane in exactly one point.
pub(super) fn is_met<S: Scalar>(
    ray: &RayOf<S>,
    one: &TriangleOf<S>,
    other: &TriangleOf<S>,
) -> bool {
    // Find the corners that the triangles share. Compare their bits: on a CPU that treats subnormal
    // numbers as zero, a floating-point comparison would consider different corners equal.
    let bits = |corner: &[S; 3]| corner.map(|x| (x.rank(), x.is_negative()));
    let is_shared = |corner: &&[S; 3]| other.0.iter().any(|c| bits(c) == bits(corner));
    let mut shared = one.0.iter().filter(is_shared);
    let Some(&p) = shared.next() else { return false };
    let q = shared.next().copied().unwrap_or(p);
    // With three shared corners, the triangles lie in the same plane.
    if shared.next().is_some() {
        return true;
    }
    // The ray nearly always misses the edge, and f64 arithmetic can prove that. For f32
    // coordinates, integers are just as fast.
    if const { is_f64::<S>() } && is_plain(ray, &TriangleOf([p, q, q])) {
        let vec3 = |v: [S; 3]| Vec3::splat(v.map(Into::into));
        if float::passes([p, q].map(vec3), vec3(ray.origin), vec3(ray.dir)) {
            return false;
        }
    }
    let (points, dir) = (Scale::of(&[ray.origin, p, q]), Scale::of(&[ray.dir]));
    at_tier!(S, points.tier(dir), holds::<S, C, N, V>(ray, [p, q], (points, dir)))
}

fn holds<S: Scalar, const C: usize, const N: usize, const V: usize>(
    ray: &RayOf<S>,
    [p, q]: [[S; 3]; 2],
    (points, dir): (Scale, Scale),
) -> bool {
    let (o, d) = (points.vector::<S, C>(ray.origin), dir.vector::<S, C>(ray.dir));
    let seen = |corner: [S; 3]| {
        let c = points.vector::<S, C>(corner);
        [c[0] - o[0], c[1] - o[1], c[2] - o[2]]
    };
    let (p, q) = (seen(p), seen(q));
    let is_zero = |x: &Int<N>| x.sign() == Ordering::Equal;
    let through = |corner: &[Int<C>; 3]| {
        let moment: [Int<N>; 3] = cross(&d, corner);
        moment.iter().all(is_zero)
    };
    let normal: [Int<N>; 3] = cross(&p, &q);
    // If only one corner is shared, the normal is 0, and the test below would decide nothing.
    if normal.iter().all(is_zero) {
        return through(&p);
    }
    // If d·(P × Q) = 0, the ray lies in the plane through its origin and the edge, so its line
    // meets the edge's line.
    let volume: Int<V> = dot(&d, &normal);
    volume.sign().is_eq()
}
