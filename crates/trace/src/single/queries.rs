//! What is asked of one ray: its closest hit, any hit, or all of them.

use std::marker::PhantomData;

use intertri::internal::Test;
use intertri::simd::{Simd, WithSimd};
use intertri::{ClosestHit, Counts, Hit, LaneQueries, PreparedRay, Ray};

use super::stack::Kept;
use super::traverse::{Visit, traverse};
use crate::tree::{Bvh, Leaf};

/// The closest hit of a ray; with `ANY`, some hit.
pub(crate) struct Closest<'a, T, const ANY: bool> {
    pub(crate) bvh: &'a Bvh,
    pub(crate) test: T,
    pub(crate) ray: &'a Ray,
    pub(crate) kept: &'a mut Kept,
    pub(crate) counts: &'a mut Counts,
}

impl<T: LaneQueries, const ANY: bool> WithSimd for Closest<'_, T, ANY> {
    type Output = ClosestHit;

    #[inline(always)]
    fn run<S: Simd>(self) -> ClosestHit {
        let Self { bvh, test, ray, kept, counts } = self;
        let (prepared, closest) = (test.prepare_ray(ray), ClosestHit::new(ray.t_max));
        let level = PhantomData::<S>;
        let mut visitor =
            VisitClosest::<_, _, ANY> { bvh, test, ray: prepared, closest, counts, level };
        traverse::<S>(bvh, ray, kept, !ANY, &mut visitor);
        visitor.closest
    }
}

/// The closest hit of a ray, with its t and weights.
pub(crate) struct Hits<'a, T> {
    pub(crate) bvh: &'a Bvh,
    pub(crate) test: T,
    pub(crate) ray: &'a Ray,
}

impl<T: LaneQueries> WithSimd for Hits<'_, T> {
    type Output = Option<Hit>;

    #[inline(always)]
    fn run<S: Simd>(self) -> Option<Hit> {
        let Self { bvh, test, ray } = self;
        let (kept, counts) = (&mut *Kept::lend(bvh), &mut Counts::default());
        let closest = Closest::<_, false> { bvh, test, ray, kept, counts }.run::<S>();
        test.hit(ray, &closest, |place| bvh.triangle_in(place))
    }
}

struct VisitClosest<'a, T: Test, S: Simd, const ANY: bool> {
    bvh: &'a Bvh,
    test: T,
    ray: PreparedRay<T>,
    closest: ClosestHit,
    counts: &'a mut Counts,
    level: PhantomData<S>,
}

impl<T: LaneQueries, S: Simd, const ANY: bool> Visit for VisitClosest<'_, T, S, ANY> {
    #[inline(always)]
    fn visit(&mut self, leaf: usize) -> Option<f32> {
        let Self { bvh, test, ray, closest, counts, .. } = self;
        let Leaf { block, indices } = &bvh.leaves[leaf];
        let find = |place| bvh.triangle_in(place);
        test.closest_in::<S>(ray, block, indices, 8 * leaf as u32, find, closest, counts);
        if ANY && closest.is_hit() { None } else { Some(closest.t_hi()) }
    }
}

/// The places of all triangles that a ray hits, in the order in which they are found.
pub(crate) struct All<'a, T> {
    pub(crate) bvh: &'a Bvh,
    pub(crate) test: T,
    pub(crate) ray: &'a Ray,
}

impl<T: LaneQueries> WithSimd for All<'_, T> {
    type Output = Vec<u32>;

    #[inline(always)]
    fn run<S: Simd>(self) -> Vec<u32> {
        let Self { bvh, test, ray } = self;
        let mut visitor = VisitAll { bvh, test, ray, places: Vec::new(), level: PhantomData::<S> };
        traverse::<S>(bvh, ray, &mut Kept::lend(bvh), false, &mut visitor);
        visitor.places
    }
}

struct VisitAll<'a, T, S> {
    bvh: &'a Bvh,
    test: T,
    ray: &'a Ray,
    places: Vec<u32>,
    level: PhantomData<S>,
}

impl<T: LaneQueries, S: Simd> Visit for VisitAll<'_, T, S> {
    #[inline(always)]
    fn visit(&mut self, leaf: usize) -> Option<f32> {
        let block = &self.bvh.leaves[leaf].block;
        let hits = self.test.block_in::<S, 8>(self.ray, block, &mut Counts::default());
        for lane in (0..8).filter(|lane| hits.bits >> lane & 1 != 0) {
            self.places.push(8 * leaf as u32 + lane);
        }
        Some(self.ray.t_max)
    }
}
