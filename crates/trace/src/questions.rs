//! The questions of either mode, compiled here: a generic function is compiled again by every crate that calls
//! it, for each level of instructions, which takes minutes.

use intertri::lanes::{Simd, WithSimd};
use intertri::{Counts, Hit, Mode, Ray, Which};

use crate::answer::Answer;
use crate::batch::{self, OfMode};
use crate::bvh::Bvh;
use crate::search;

/// The same of either mode.
macro_rules! of_either {
    ($which:expr, $mode:ident => $ask:expr) => {
        match $which {
            Which::Certified($mode) => $ask,
            Which::Double($mode) => $ask,
        }
    };
}

/// Runs at the level of a mode.
fn run<M: Mode, W: WithSimd>(mode: &M, work: W) -> W::Output {
    mode.level().run(work)
}

/// See [`Bvh::closest`].
pub(crate) fn closest(bvh: &Bvh, which: Which<'_>, ray: &Ray) -> Hit {
    of_either!(which, mode => run(mode, Closest { bvh, mode, ray }))
}

/// See [`Bvh::any`].
pub(crate) fn any(bvh: &Bvh, which: Which<'_>, ray: &Ray) -> bool {
    of_either!(which, mode => run(mode, Any { bvh, mode, ray }))
}

/// See [`Bvh::all`].
pub(crate) fn all(bvh: &Bvh, which: Which<'_>, ray: &Ray) -> Vec<Hit> {
    of_either!(which, mode => run(mode, All { bvh, mode, ray }))
}

/// See [`Bvh::closest_of_each`].
pub(crate) fn closest_of_each(
    bvh: &Bvh,
    which: Which<'_>,
    rays: &[Ray],
    hits: &mut [Hit],
) -> Counts {
    of_each(bvh, which, rays, hits)
}

/// See [`Bvh::triangles_of_each`].
pub(crate) fn triangles_of_each(
    bvh: &Bvh,
    which: Which<'_>,
    rays: &[Ray],
    triangles: &mut [u32],
) -> Counts {
    of_each(bvh, which, rays, triangles)
}

/// See [`Bvh::any_of_each`].
pub(crate) fn any_of_each(bvh: &Bvh, which: Which<'_>, rays: &[Ray], hits: &mut [bool]) -> Counts {
    of_each(bvh, which, rays, hits)
}

fn of_each<A: Answer>(bvh: &Bvh, which: Which<'_>, rays: &[Ray], answers: &mut [A]) -> Counts {
    of_either!(which, mode => batch::answer(&OfMode { bvh, mode }, rays, answers))
}

struct Closest<'a, M> {
    bvh: &'a Bvh,
    mode: &'a M,
    ray: &'a Ray,
}

impl<M: Mode> WithSimd for Closest<'_, M> {
    type Output = Hit;
    #[inline(always)]
    fn run<S: Simd>(self) -> Hit {
        let Self { bvh, mode, ray } = self;
        let (kept, counts) = (&mut bvh.kept(), &mut Counts::default());
        let best = search::closest::<M, S>(bvh, mode, ray, false, kept, counts);
        bvh.hit(mode, ray, &best)
    }
}

struct Any<'a, M> {
    bvh: &'a Bvh,
    mode: &'a M,
    ray: &'a Ray,
}

impl<M: Mode> WithSimd for Any<'_, M> {
    type Output = bool;
    #[inline(always)]
    fn run<S: Simd>(self) -> bool {
        let Self { bvh, mode, ray } = self;
        let (kept, counts) = (&mut bvh.kept(), &mut Counts::default());
        search::closest::<M, S>(bvh, mode, ray, true, kept, counts).is_hit()
    }
}

struct All<'a, M> {
    bvh: &'a Bvh,
    mode: &'a M,
    ray: &'a Ray,
}

impl<M: Mode> WithSimd for All<'_, M> {
    type Output = Vec<Hit>;
    #[inline(always)]
    fn run<S: Simd>(self) -> Vec<Hit> {
        let Self { bvh, mode, ray } = self;
        let found = search::all::<M, S>(bvh, mode, ray, &mut bvh.kept());
        let hit =
            |(place, t): (u32, f64)| Hit::at(t, bvh.index_of(place), ray, &bvh.triangle_in(place));
        let mut hits: Vec<Hit> = found.into_iter().map(hit).collect();
        hits.sort_unstable_by_key(|hit| hit.triangle);
        hits
    }
}
