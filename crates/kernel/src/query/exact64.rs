//! Exact queries over f64 slices: a plain loop over groups of eight triangles, in f64 lanes with an
//! error bound. Integers settle the lanes that the bound leaves undecided.

use alloc::vec::Vec;
use core::cmp::Ordering;

use crate::exact::{self, Rule, decide, hits64, is_plain};
use crate::packet::RayLanes;
use crate::resolve::sort_hits;
use crate::simd::{Level, Mask, Simd, Vec3, WithSimd, lanes_of};
use crate::{Hit, Ray64, Triangle64};

/// Returns the closest hit. If two hits have the same t, the lower index wins.
#[inline]
pub(super) fn closest(
    rule: Rule,
    level: Level,
    triangles: &[Triangle64],
    ray: &Ray64,
) -> Option<Hit> {
    let mut best: Option<(f64, u32)> = None;
    level.run(ForEachHit {
        rule,
        triangles,
        ray,
        found: |index| {
            let triangle = &triangles[index as usize];
            let t = exact::t(ray, triangle);
            // Rounding preserves order, so exact values of t are compared only if the rounded
            // values are equal.
            let closer = best.is_none_or(|(least, other)| match t.total_cmp(&least) {
                Ordering::Equal => exact::order(ray, triangle, &triangles[other as usize]).is_lt(),
                order => order.is_lt(),
            });
            if closer {
                best = Some((t, index));
            }
            true
        },
    });
    let mut hit = [Hit::MISS];
    let (_, index) = best?;
    hits64(level, &[(ray, &triangles[index as usize], index)], &mut hit);
    hit[0].some()
}

/// Returns whether the ray hits anything.
#[inline]
pub(super) fn any(rule: Rule, level: Level, triangles: &[Triangle64], ray: &Ray64) -> bool {
    let mut any = false;
    level.run(ForEachHit {
        rule,
        triangles,
        ray,
        found: |_| {
            any = true;
            false
        },
    });
    any
}

/// Returns every hit, sorted by exact t and, for equal t, by index.
#[inline]
pub(super) fn all(rule: Rule, level: Level, triangles: &[Triangle64], ray: &Ray64) -> Vec<Hit> {
    let mut pairs = Vec::new();
    level.run(ForEachHit {
        rule,
        triangles,
        ray,
        found: |index| {
            pairs.push((ray, &triangles[index as usize], index));
            true
        },
    });
    let mut hits = alloc::vec![Hit::MISS; pairs.len()];
    hits64(level, &pairs, &mut hits);
    let found = |hit: &Hit| &triangles[hit.triangle as usize];
    sort_hits(&mut hits, |hit| hit, |a, b| exact::order(ray, found(a), found(b)));
    hits
}

/// Calls `found` for each triangle that a ray hits, in the order of the slice, until `found`
/// returns false.
struct ForEachHit<'a, F> {
    rule: Rule,
    triangles: &'a [Triangle64],
    ray: &'a Ray64,
    found: F,
}

impl<F: FnMut(u32) -> bool> WithSimd for ForEachHit<'_, F> {
    type Output = ();

    #[inline(always)]
    fn run<S: Simd>(self) {
        let Self { rule, triangles, ray, mut found } = self;
        let lanes = RayLanes::<S::F64x8>::of_ray(ray);
        for (some, first) in triangles.chunks(8).zip((0..).step_by(8)) {
            // The error bound does not hold where products of coordinates could overflow or
            // underflow. The affected triangles are tested with integers.
            let (mut numbers, mut plain) = ([[[0.0; 8]; 3]; 3], 0_u32);
            for (lane, triangle) in some.iter().enumerate() {
                for (to, from) in numbers.iter_mut().zip(&triangle.0) {
                    (to[0][lane], to[1][lane], to[2][lane]) = (from[0], from[1], from[2]);
                }
                plain |= u32::from(is_plain(ray, triangle)) << lane;
            }
            let [c1, c2, c3] = &numbers;
            let decided = decide([Vec3::load(c1), Vec3::load(c2), Vec3::load(c3)], &lanes);
            // Under the closed rule, a ray that meets an edge exactly hits the triangle. Under
            // `once`, the tie rule has to decide.
            let sure = if rule == Rule::Closed { decided.closed } else { decided.inside };
            let given = (1_u32 << some.len()) - 1;
            // Neither verdict is valid for a lane that is not plain.
            let (miss, hit) = (decided.miss.bits() & plain, sure.bits() & plain);
            for lane in lanes_of(given & !miss) {
                let is_hit = hit >> lane & 1 != 0 || exact::hit(rule, ray, &some[lane]);
                if is_hit && !found(first + lane as u32) {
                    return;
                }
            }
        }
    }
}
