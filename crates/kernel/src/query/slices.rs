//! Queries over slices, one row of triangles at a time. A row has one triangle per lane of a
//! register.

use alloc::vec::Vec;

use super::blocks::Blocks;
use super::rows::Rows;
use crate::filter::{Counts, Filter, Rays, Verdicts};
use crate::lane_queries::{ClosestHit, LanePairs, RayOnRow};
use crate::resolve::sort_hits;
use crate::simd::{Lanes, Mask, Simd, WithSimd, lanes_of};
use crate::{Crossings, Hit, LeafSlot, Ray, RayId, Triangle, TriangleId};

/// See [`Mode::closest`](super::Mode::closest).
pub(super) fn closest(filter: Filter<'_>, rows: Rows<'_>, ray: &Ray) -> Option<Hit> {
    filter.level().run(Closest { filter, rows, ray })
}

/// See [`Mode::any`](super::Mode::any).
pub(super) fn any(filter: Filter<'_>, rows: Rows<'_>, ray: &Ray) -> bool {
    filter.level().run(Any { filter, rows, ray })
}

/// See [`Mode::all`](super::Mode::all).
pub(super) fn all(filter: Filter<'_>, rows: Rows<'_>, ray: &Ray) -> Vec<Hit> {
    // Sort by the exact t if rounded values are equal: the resolver compares the triangles
    // themselves.
    let mut hits = filter.level().run(All { filter, rows, ray });
    let found = |hit: &Hit| rows.triangle(LeafSlot(hit.triangle));
    sort_hits(
        &mut hits,
        |hit| hit,
        |a, b| {
            let slots = [LeafSlot(a.triangle), LeafSlot(b.triangle)];
            filter.resolver().order(ray, [&found(a), &found(b)], (RayId(0), slots))
        },
    );
    hits
}

/// See [`Blocks::count_crossings`].
pub(super) fn count_crossings(filter: Filter<'_>, rows: Rows<'_>, ray: &Ray) -> Crossings {
    filter.level().run(CountCrossings { filter, rows, ray })
}

/// The minimum number of rays for which loading the triangles into lanes only once pays off.
const MANY: usize = 4;

/// See [`Mode::closest_batch`](super::Mode::closest_batch).
pub(super) fn closest_batch(
    filter: Filter<'_>,
    triangles: &[Triangle],
    rays: &[Ray],
    hits: &mut [Hit],
) {
    let blocks;
    let rows = if rays.len() < MANY {
        Rows::Slice(triangles)
    } else {
        blocks = Blocks::new(triangles);
        Rows::Blocks(&blocks)
    };
    for (ray, hit) in rays.iter().zip(hits) {
        *hit = closest(filter, rows, ray).unwrap_or(Hit::MISS);
    }
}

/// Tests a ray against all triangles, row by row. If a row may contain hits, calls `visit` with the
/// verdicts and the index of the row's first triangle. `visit` returns the new far end, or `None`
/// to stop.
#[inline(always)]
fn each_row<S: Simd>(
    filter: &Filter<'_>,
    rows: Rows<'_>,
    ray: &Ray,
    mut visit: impl FnMut(&Verdicts<S::F32s>, LeafSlot) -> Option<f32>,
) {
    let lanes = Rays::splat(&Rays::of_ray(ray, filter.threshold(), filter.room()));
    let (mut far, mut counts) = (ray.t_max, Counts::default());
    for first in (0..rows.len()).step_by(S::F32s::N) {
        let triangles = rows.row::<S>(first);
        // The last row may have fewer triangles than lanes. `len - first` is at least 1, so the
        // shift stays below 32.
        let live = u32::MAX >> (32 - (rows.len() - first).min(S::F32s::N));
        let verdicts =
            filter.test::<S::F32s>(&triangles, &lanes, Lanes::splat(far), live, &mut counts);
        if verdicts.lanes() != 0 {
            match visit(&verdicts, LeafSlot(first as u32)) {
                Some(nearer) => far = nearer,
                None => return,
            }
        }
    }
}

/// Returns the lanes of a row that are hits, as bits. If `enough` is set, one hit suffices.
#[inline(always)]
fn hits_in_row<S: Simd>(
    verdicts: &Verdicts<S::F32s>,
    t_max: f32,
    pairs: &impl LanePairs,
    enough: bool,
) -> u32 {
    // The filter's hits may be beyond the end of the interval, so the resolver also settles hits
    // whose interval of t reaches that end.
    let hits = verdicts.hit & verdicts.t_hi.lt(Lanes::splat(t_max)).bits();
    let open = verdicts.lanes() & !hits;
    // If one hit suffices, further calls to the resolver would be wasted.
    if open == 0 || enough && hits != 0 { hits } else { hits | pairs.meeting(open) }
}

/// Counts the crossings of a ray.
struct CountCrossings<'a> {
    filter: Filter<'a>,
    rows: Rows<'a>,
    ray: &'a Ray,
}

impl WithSimd for CountCrossings<'_> {
    type Output = Crossings;

    #[inline(always)]
    fn run<S: Simd>(self) -> Crossings {
        let Self { filter, rows, ray } = self;
        let (mut crossings, find) = (Crossings::default(), |slot| rows.triangle(slot));
        each_row::<S>(
            &filter,
            rows,
            ray,
            #[inline(always)]
            |verdicts, first| {
                let pairs = RayOnRow { resolver: filter.resolver(), ray, first, find };
                // A ray that certainly passes inside all edges crosses the triangle, and the filter
                // has already determined its side. Near an edge, the exact rule decides.
                let sure = verdicts.hit & verdicts.t_hi.lt(Lanes::splat(ray.t_max)).bits();
                let open = verdicts.lanes() & !sure;
                let [mut crossed, mut leaving] = [sure, sure & verdicts.leaves];
                if open != 0 {
                    let more = pairs.crossings(open);
                    (crossed, leaving) = (crossed | more[0], leaving | more[1]);
                }
                for lane in lanes_of(crossed) {
                    crossings.add(leaving >> lane & 1 != 0);
                }
                Some(ray.t_max)
            },
        );
        crossings
    }
}

/// Finds the closest hit of a ray.
struct Closest<'a> {
    filter: Filter<'a>,
    rows: Rows<'a>,
    ray: &'a Ray,
}

impl WithSimd for Closest<'_> {
    type Output = Option<Hit>;

    #[inline(always)]
    fn run<S: Simd>(self) -> Option<Hit> {
        let Self { filter, rows, ray } = self;
        let (mut closest, find) = (ClosestHit::new(ray.t_max), |slot| rows.triangle(slot));
        each_row::<S>(
            &filter,
            rows,
            ray,
            #[inline(always)]
            |verdicts, first| {
                let pairs = RayOnRow { resolver: filter.resolver(), ray, first, find };
                // The nearer the closest hit so far, the more of the following rows are rejected
                // before bounds on their t are computed.
                closest.offer_row(verdicts, first, &pairs);
                Some(closest.t_hi())
            },
        );
        filter.hit(ray, &closest, find)
    }
}

/// Tests whether a ray hits anything.
struct Any<'a> {
    filter: Filter<'a>,
    rows: Rows<'a>,
    ray: &'a Ray,
}

impl WithSimd for Any<'_> {
    type Output = bool;

    #[inline(always)]
    fn run<S: Simd>(self) -> bool {
        let Self { filter, rows, ray } = self;
        let (mut any, find) = (false, |slot| rows.triangle(slot));
        each_row::<S>(
            &filter,
            rows,
            ray,
            #[inline(always)]
            |verdicts, first| {
                let pairs = RayOnRow { resolver: filter.resolver(), ray, first, find };
                any = hits_in_row::<S>(verdicts, ray.t_max, &pairs, true) != 0;
                (!any).then_some(ray.t_max)
            },
        );
        any
    }
}

/// Finds every hit of a ray, in the order of the triangles.
struct All<'a> {
    filter: Filter<'a>,
    rows: Rows<'a>,
    ray: &'a Ray,
}

impl WithSimd for All<'_> {
    type Output = Vec<Hit>;

    #[inline(always)]
    fn run<S: Simd>(self) -> Vec<Hit> {
        let Self { filter, rows, ray } = self;
        let (mut hits, find) = (Vec::new(), |slot| rows.triangle(slot));
        each_row::<S>(
            &filter,
            rows,
            ray,
            #[inline(always)]
            |verdicts, first| {
                let pairs = RayOnRow { resolver: filter.resolver(), ray, first, find };
                for lane in lanes_of(hits_in_row::<S>(verdicts, ray.t_max, &pairs, false)) {
                    let (triangle, (id, slot)) = (pairs.triangle(lane), pairs.ids(lane));
                    let index = TriangleId(slot.0);
                    hits.push(pairs.resolver.hit_attributes(ray, &triangle, index, (id, slot)));
                }
                Some(ray.t_max)
            },
        );
        hits
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::simd::Level;
    use crate::{Mode, Threshold};

    /// A level with one-lane registers, as in WebAssembly without simd128.
    #[derive(Clone, Copy)]
    struct OneLane<S>(S);

    impl<S: Simd> Simd for OneLane<S> {
        type F32x4 = S::F32x4;
        type F32x8 = S::F32x8;
        type F32x16 = S::F32x16;
        type F64x4 = S::F64x4;
        type F64x8 = S::F64x8;
        type I64x8 = S::I64x8;
        type WideInts = S::WideInts;
        type F32s = f32;
        type F64s = f64;
        const LEVEL: Level = S::LEVEL;
    }

    /// Finds the closest hit, whether the ray hits anything, and the number of hits.
    struct ByOneLane<'a>(Filter<'a>, &'a [Triangle], &'a Ray);

    impl WithSimd for ByOneLane<'_> {
        type Output = (Option<Hit>, bool, usize);

        #[inline(always)]
        fn run<S: Simd>(self) -> Self::Output {
            let Self(filter, triangles, ray) = self;
            let rows = Rows::Slice(triangles);
            let closest = Closest { filter, rows, ray }.run::<OneLane<S>>();
            let any = Any { filter, rows, ray }.run::<OneLane<S>>();
            (closest, any, All { filter, rows, ray }.run::<OneLane<S>>().len())
        }
    }

    /// Returns a small integer, so that rays often meet edges, corners, and planes exactly.
    fn number(state: &mut u64) -> f32 {
        *state = state.wrapping_mul(0x5851_f42d_4c95_7f2d).wrapping_add(0x1405_7b7e_f767_814f);
        ((*state >> 33) % 9) as f32 - 4.0
    }

    fn check(mode: Mode, triangles: &[Triangle], ray: &Ray) -> bool {
        let want = mode.closest(triangles, ray);
        let all = mode.all(triangles, ray).len();
        for level in Level::all() {
            let found = level.run(ByOneLane(mode.filter(), triangles, ray));
            assert_eq!(found, (want, want.is_some(), all), "{triangles:?} {ray:?}");
        }
        want.is_some()
    }

    #[test]
    fn one_lane_answers_as_many_do() {
        let (state, mut hits) = (&mut 7, 0);
        for turn in 0..3000 {
            let mut point = || {
                let scale = if turn % 2 == 0 { 1.0 } else { 1.1 };
                [0, 1, 2].map(|_| scale * number(state))
            };
            let triangles: Vec<_> =
                (0..turn % 37).map(|_| Triangle([point(), point(), point()])).collect();
            let ray = Ray::new(point(), point()).between(0.0, 0.5 * (turn % 16) as f32);
            hits += usize::from(check(Mode::exact(), &triangles, &ray));
            check(Mode::certified_with(Threshold::ZERO), &triangles, &ray);
            check(Mode::once(), &triangles, &ray);
        }
        assert!(hits > 500, "{hits}");
    }
}
