//! Every hit of the rays that are at leaves: pairs, crossings, or what winds around where they start.

use intertri::internal::exact::Side;
use intertri::internal::{BlockHits, Filter};
use intertri::{Crossings, Ray};

use crate::answers::Answers;
use crate::pairs::{HitPairs, NearestFew};
use crate::place::Place;
use crate::single::is_held;
use crate::tree::Tree;

/// A ray of a stream and how far it looks for hits.
pub(super) struct Looking<'a> {
    pub(super) bvh: &'a Tree,
    pub(super) test: Filter<'a>,
    pub(super) number: u32,
    pub(super) ray: &'a Ray,
    /// Its nearest hits, where a number of them is asked for.
    pub(super) few: Option<&'a mut NearestFew>,
    pub(super) far: f32,
}

impl Looking<'_> {
    /// Takes the hits with a leaf; whether the ray needs no more.
    #[inline(always)]
    pub(super) fn take(
        &mut self,
        hits: &BlockHits,
        leaf: usize,
        answers: &mut Answers<'_>,
    ) -> bool {
        match answers {
            Answers::Pairs(pairs) => self.pairs(hits, leaf, pairs),
            Answers::Crossings(all) => {
                self.crossings(hits, leaf, &mut all[self.number as usize]);
                false
            }
            Answers::Places(places) => self.winding(hits, leaf, &mut places[self.number as usize]),
            Answers::Hits(_) | Answers::Triangles(_) | Answers::Any(_) => false,
        }
    }

    /// Lists the hits.
    #[inline(always)]
    fn pairs(&mut self, hits: &BlockHits, leaf: usize, pairs: &mut HitPairs) -> bool {
        if !pairs.reserve(8) {
            return true;
        }
        let (first, number) = (8 * leaf as u32, self.number);
        for lane in lanes(hits.sure) {
            pairs.push(number, first + lane);
        }
        let is_limited = self.few.is_some();
        hits.undecided != 0 && self.settle(hits.undecided, first, pairs)
            || is_limited && self.shorten(hits, pairs)
    }

    /// Lists those of some lanes that the resolver says are hits.
    #[cold]
    #[inline(never)]
    fn settle(&mut self, undecided: u32, first: u32, pairs: &mut HitPairs) -> bool {
        for lane in lanes(undecided) {
            let triangle = self.bvh.triangle_in(first + lane);
            let numbers = (self.number, first + lane);
            let Some(t) = self.test.resolver().hit(self.ray, &triangle, numbers) else { continue };
            pairs.push(self.number, first + lane);
            if let (Some(few), Some(most)) = (&mut self.few, pairs.limit) {
                match few.add((t as f32).next_up(), most, self.far) {
                    Some(far) => self.far = far,
                    None => pairs.is_full = true,
                }
            }
        }
        pairs.is_full
    }

    /// Nothing counts beyond the last of as many hits as are asked for.
    #[inline(never)]
    fn shorten(&mut self, hits: &BlockHits, pairs: &mut HitPairs) -> bool {
        if let (Some(few), Some(most)) = (&mut self.few, pairs.limit) {
            for lane in lanes(hits.sure) {
                match few.add(hits.t_hi[lane as usize % 8], most, self.far) {
                    Some(far) => self.far = far,
                    None => pairs.is_full = true,
                }
            }
        }
        pairs.is_full
    }

    /// Counts the crossings. Who is surely inside of all edges crosses; on an edge the exact rule decides.
    #[inline(always)]
    fn crossings(&self, hits: &BlockHits, leaf: usize, crossings: &mut Crossings) {
        for lane in lanes(hits.sure) {
            crossings.add(hits.leaves >> lane & 1 != 0);
        }
        for lane in lanes(hits.undecided) {
            if let Some(side) = self.crossed(8 * leaf as u32 + lane) {
                crossings.add(side == Side::Leaves);
            }
        }
    }

    /// Counts what winds around where the ray starts; whether that lies on a triangle. One that it lies on is
    /// never decided by the filter: T is 0, and no two edges have sure signs that differ.
    #[inline(always)]
    fn winding(&self, hits: &BlockHits, leaf: usize, place: &mut Place) -> bool {
        for lane in lanes(hits.sure) {
            *place = place.crossed(hits.leaves >> lane & 1 != 0);
        }
        for lane in lanes(hits.undecided) {
            let at = 8 * leaf as u32 + lane;
            if self.starts_on(at) {
                *place = Place::Surface;
            } else if let Some(side) = self.crossed(at) {
                *place = place.crossed(side == Side::Leaves);
            }
        }
        *place == Place::Surface
    }

    /// The side from which the ray crosses the triangle in a place, if it does.
    #[inline(always)]
    fn crossed(&self, place: u32) -> Option<Side> {
        let triangle = self.bvh.triangle_in(place);
        self.test.resolver().crossing(self.ray, &triangle, (self.number, place))
    }

    /// Whether the ray starts on the triangle in a place.
    #[inline(always)]
    fn starts_on(&self, place: u32) -> bool {
        let triangle = self.bvh.triangle_in(place);
        self.test.resolver().starts_on(self.ray, &triangle, (self.number, place))
    }

    /// Takes every hit of a ray that is asked by itself, from the places of the triangles.
    pub(super) fn take_alone(&mut self, places: &[u32], answers: &mut Answers<'_>) {
        let number = self.number as usize;
        let crossed = |place: &u32| self.crossed(*place);
        let leaves = places.iter().filter_map(crossed).map(|side| side == Side::Leaves);
        match answers {
            Answers::Pairs(pairs) => {
                if pairs.reserve(places.len()) {
                    for &place in places {
                        pairs.push(self.number, place);
                    }
                }
            }
            Answers::Crossings(all) => leaves.for_each(|leaves| all[number].add(leaves)),
            Answers::Places(all) => {
                let starts_on = |place| self.starts_on(place);
                all[number] = if is_held(self.bvh, self.ray.origin, starts_on) {
                    Place::Surface
                } else {
                    leaves.fold(all[number], Place::crossed)
                };
            }
            Answers::Hits(_) | Answers::Triangles(_) | Answers::Any(_) => (),
        }
    }
}

/// The lanes of a mask.
#[inline(always)]
fn lanes(mut mask: u32) -> impl Iterator<Item = u32> {
    std::iter::from_fn(move || {
        let lane = mask.trailing_zeros();
        mask &= mask.wrapping_sub(1);
        (lane < 32).then_some(lane)
    })
}
