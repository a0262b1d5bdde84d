//! Computes the hit attributes of eight pairs, each a ray and a triangle that it is known to hit.

use super::attributes;
use super::input::subnormals_are_read;
use super::rounded::Quotients;
use crate::Hit;
use crate::hit_attributes::Pairs;
use crate::simd::{Lanes, Mask, Simd, Vec3, lanes_of};

/// Returns t for each lane and the lanes in which t is proven to be correctly rounded. In each
/// lane, the ray must be known to hit the triangle.
#[inline(always)]
pub(crate) fn t_in<D: Lanes<Scalar = f64>>(
    corners: [Vec3<D>; 3],
    origin: Vec3<D>,
    dir: Vec3<D>,
) -> (D, u32) {
    let (t, sure) = Quotients::new(corners, origin, dir).t();
    (t, if subnormals_are_read() { sure.bits() } else { 0 })
}

/// Returns t, u, and v of each lane, and the lanes in which they are proven to be correctly rounded.
#[inline(always)]
pub(super) fn quotients_in<S: Simd>(pairs: &Pairs) -> ([[f64; 8]; 3], u32) {
    // Process four pairs at a time, because some CPUs lower their clock rate for even a single
    // eight-lane division.
    let (mut numbers, mut sure) = ([[0.0; 8]; 3], 0);
    for from in [0, 4] {
        let (corners, origin, dir) = pairs.lanes::<S::F64x4>(from);
        let seen = Quotients::new(corners, origin, dir);
        let ((t, t_sure), (u, v, weights_sure)) = (seen.t(), seen.weights());
        t.store(&mut numbers[0][from..]);
        u.store(&mut numbers[1][from..]);
        v.store(&mut numbers[2][from..]);
        sure |= (t_sure & weights_sure).bits() << from;
    }
    // If the CPU treats subnormal numbers as zero, trust no lane: the hits are then computed from the
    // bits of the coordinates.
    (numbers, if subnormals_are_read() { sure } else { 0 })
}

/// Returns the hits of the first `len` lanes, with t, u, and v correctly rounded. The other
/// elements are meaningless.
#[inline(always)]
pub fn hits_in<S: Simd>(pairs: &Pairs, len: usize) -> [Hit; 8] {
    let ([t, u, v], sure) = quotients_in::<S>(pairs);
    let mut hits = pairs.hits(&t, &u, &v);
    for lane in lanes_of(!sure & ((1 << len) - 1)) {
        let (ray, triangle, _) = pairs.pair(lane);
        (hits[lane].t, hits[lane].u, hits[lane].v) = attributes(&ray, &triangle);
    }
    hits
}
