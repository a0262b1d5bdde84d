//! What is asked of one ray: its closest hit, any hit, or all of them.

use std::marker::PhantomData;

use intertri::internal::Test;
use intertri::simd::{Simd, WithSimd};
use intertri::{ClosestHit, Counts, Hit, LaneQueries, PreparedRay, Ray};

use super::stack::Kept;
use super::traverse::{Visit, traverse};
use crate::select::{Choice, chosen};
use crate::tree::{Leaf, Tree};

/// The closest hit of a ray; with `ANY`, some hit.
pub(crate) struct Closest<'a, T, const ANY: bool> {
    pub(crate) bvh: &'a Tree,
    /// By reference: it is larger than what the walk reads of it.
    pub(crate) test: &'a T,
    pub(crate) ray: &'a Ray,
    /// Which triangles count, and as which of the query's rays this one skips some.
    pub(crate) choice: (&'a Choice<'a>, usize),
    pub(crate) kept: &'a mut Kept,
}

impl<T: LaneQueries, const ANY: bool> WithSimd for Closest<'_, T, ANY> {
    type Output = (ClosestHit, Counts);

    #[inline(always)]
    fn run<S: Simd>(self) -> Self::Output {
        let Self { bvh, test, ray, choice, kept } = self;
        let prepared = test.prepare_numbered(ray, choice.1 as u32);
        let closest = test.no_hit(ray);
        let (level, counts) = (PhantomData::<S>, Counts::default());
        let (choice, _) = choice;
        let mut visitor =
            VisitClosest::<_, _, ANY> { bvh, test, ray: prepared, choice, closest, counts, level };
        traverse::<S>(bvh, (ray, test.resolver()), kept, !ANY, &mut visitor);
        (visitor.closest, visitor.counts)
    }
}

/// The closest hit of a ray, with its t and weights.
pub(crate) struct Hits<'a, T> {
    pub(crate) bvh: &'a Tree,
    pub(crate) test: &'a T,
    pub(crate) ray: &'a Ray,
    pub(crate) choice: &'a Choice<'a>,
    pub(crate) kept: &'a mut Kept,
}

impl<T: LaneQueries> WithSimd for Hits<'_, T> {
    type Output = Option<Hit>;

    #[inline(always)]
    fn run<S: Simd>(self) -> Option<Hit> {
        let Self { bvh, test, ray, choice, kept } = self;
        let choice = (choice, 0);
        let (closest, _) = Closest::<_, false> { bvh, test, ray, choice, kept }.run::<S>();
        test.hit(ray, &closest, |place| bvh.triangle_in(place))
    }
}

struct VisitClosest<'a, T: Test, S: Simd, const ANY: bool> {
    bvh: &'a Tree,
    test: &'a T,
    ray: PreparedRay<T>,
    choice: &'a Choice<'a>,
    closest: ClosestHit,
    counts: Counts,
    level: PhantomData<S>,
}

impl<T: LaneQueries, S: Simd, const ANY: bool> Visit for VisitClosest<'_, T, S, ANY> {
    #[inline(always)]
    fn visit(&mut self, leaf: usize) -> Option<f32> {
        let Self { bvh, test, ray, choice, closest, counts, .. } = self;
        match choice {
            None => {
                let Leaf { block, indices } = &bvh.leaves[leaf];
                let find = |place| bvh.triangle_in(place);
                test.closest_in::<S>(ray, block, indices, 8 * leaf as u32, find, closest, counts);
            }
            // Counts that are lent to a call would be in memory everywhere.
            Some(select) => {
                let mut some = Counts::default();
                select.closest_in::<S, _>(bvh, **test, ray, leaf, closest, &mut some);
                *counts += some;
            }
        }
        if ANY && closest.is_hit() { None } else { Some(closest.t_hi()) }
    }
}

/// The places of all triangles that a ray hits, in the order in which they are found.
pub(crate) struct All<'a, T> {
    pub(crate) bvh: &'a Tree,
    pub(crate) test: T,
    pub(crate) ray: &'a Ray,
    /// See [`Closest::choice`].
    pub(crate) choice: (&'a Choice<'a>, usize),
}

impl<T: LaneQueries> WithSimd for All<'_, T> {
    type Output = Vec<u32>;

    #[inline(always)]
    fn run<S: Simd>(self) -> Vec<u32> {
        let Self { bvh, test, ray, choice } = self;
        let (places, level) = (Vec::new(), PhantomData::<S>);
        let prepared = test.prepare_numbered(ray, choice.1 as u32);
        let mut visitor =
            VisitAll { bvh, test, ray: prepared, asked: (choice, ray), places, level };
        traverse::<S>(bvh, (ray, test.resolver()), &mut Kept::lend(bvh), false, &mut visitor);
        visitor.places
    }
}

struct VisitAll<'a, T: Test, S> {
    bvh: &'a Tree,
    test: T,
    ray: PreparedRay<T>,
    asked: ((&'a Choice<'a>, usize), &'a Ray),
    places: Vec<u32>,
    level: PhantomData<S>,
}

impl<T: LaneQueries, S: Simd> Visit for VisitAll<'_, T, S> {
    #[inline(always)]
    fn visit(&mut self, leaf: usize) -> Option<f32> {
        let Self { bvh, test, ray, asked: ((choice, number), asked), .. } = &*self;
        let (block, place) = (&bvh.leaves[leaf].block, 8 * leaf as u32);
        let hits = test.block_at_in::<S, 8>(ray, block, place, &mut Counts::default());
        if hits.bits != 0 {
            let bits = chosen(choice, bvh, (*number, asked), leaf, hits.bits, test.resolver());
            for lane in (0..8).filter(|lane| bits >> lane & 1 != 0) {
                self.places.push(8 * leaf as u32 + lane);
            }
        }
        Some(self.asked.1.t_max)
    }
}
