//! Computes the hit attributes of f64 rays and triangles that they are known to hit, four pairs at
//! a time.

use super::attributes;
use super::input::{is_plain, subnormals_are_read};
use super::tails::SeenTails;
use crate::simd::{Lanes, Level, Mask, Simd, Vec3, WithSimd};
use crate::{Hit, Ray64, Triangle64};

/// A ray, a triangle that it is known to hit, and the triangle's index.
pub type Pair64<'a> = (&'a Ray64, &'a Triangle64, u32);

/// Computes the hits of pairs, with t, u, and v correctly rounded.
#[inline]
pub fn hits64(level: Level, pairs: &[Pair64<'_>], hits: &mut [Hit]) {
    for (pairs, hits) in pairs.chunks(4).zip(hits.chunks_mut(4)) {
        level.run(Four { pairs, hits });
    }
}

/// Up to four pairs. Eight pairs would use eight-lane divisions, and some CPUs lower their clock
/// rate for even a single one.
struct Four<'a> {
    pairs: &'a [Pair64<'a>],
    hits: &'a mut [Hit],
}

impl WithSimd for Four<'_> {
    type Output = ();

    #[inline(always)]
    fn run<S: Simd>(self) {
        let Self { pairs, hits } = self;
        let (mut numbers, mut plain) = ([[[0.0; 4]; 3]; 5], 0_u32);
        for (lane, (ray, triangle, _)) in pairs.iter().enumerate() {
            let [c1, c2, c3] = &triangle.0;
            for (to, from) in numbers.iter_mut().zip([c1, c2, c3, &ray.origin, &ray.dir]) {
                for (to, from) in to.iter_mut().zip(from) {
                    to[lane] = *from;
                }
            }
            plain |= u32::from(is_plain(ray, triangle)) << lane;
        }
        let [c1, c2, c3, org, dir] = &numbers;
        let corners = [Vec3::<S::F64x4>::load(c1), Vec3::load(c2), Vec3::load(c3)];
        let seen = SeenTails::new(corners, Vec3::load(org), Vec3::load(dir));
        let ((in_t, t_sure), (in_u, in_v, sure)) = (seen.t(), seen.weights());
        let (mut t, mut u, mut v) = ([0.0; 4], [0.0; 4], [0.0; 4]);
        in_t.store(&mut t);
        in_u.store(&mut u);
        in_v.store(&mut v);
        let sure = if subnormals_are_read() { (t_sure & sure).bits() & plain } else { 0 };
        for (lane, (&(ray, triangle, index), hit)) in pairs.iter().zip(hits).enumerate() {
            let all = (t[lane], u[lane], v[lane]);
            let (t, u, v) = if sure >> lane & 1 != 0 { all } else { attributes(ray, triangle) };
            *hit = Hit { t, u, v, triangle: index, geometry: 0 };
        }
    }
}
