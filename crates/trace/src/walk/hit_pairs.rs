//! Lists of ray-triangle pairs, one pair per hit, in the order in which the hits are found.

use std::collections::BinaryHeap;

use intertri::{Hit, LeafSlot, RayId};

/// A list of pairs in any order, whose memory grows with the number of hits.
#[derive(Default)]
pub struct HitPairs {
    pub(crate) pairs: Vec<(RayId, LeafSlot)>,
    /// The hits of the first pairs. A miss stands for a hit that has not been computed yet.
    pub(crate) hits: Vec<Hit>,
    /// The number of nearest hits to keep per ray, or `None` to keep all hits.
    pub(crate) limit: Option<usize>,
    /// Whether memory ran out while adding a pair, in which case the results are invalid.
    pub(crate) is_full: bool,
}

impl HitPairs {
    /// Clears everything and sets the number of hits to keep per ray.
    pub(crate) fn clear(&mut self, limit: Option<usize>) {
        self.pairs.clear();
        self.hits.clear();
        (self.limit, self.is_full) = (limit, false);
    }

    /// Reserves memory for more pairs. Returns whether enough memory is available.
    #[inline(always)]
    pub(crate) fn reserve(&mut self, more: usize) -> bool {
        if self.pairs.capacity() - self.pairs.len() < more {
            self.grow(more);
        }
        !self.is_full
    }

    #[cold]
    #[inline(never)]
    fn grow(&mut self, more: usize) {
        let found = self.pairs.try_reserve(more).and_then(|()| {
            // Give `hits` the capacity of `pairs`, so that one check covers both.
            let more = self.pairs.capacity() - self.hits.len();
            self.hits.try_reserve(more)
        });
        self.is_full |= found.is_err();
    }

    /// Adds a pair. Memory for the pair must have been reserved.
    #[inline(always)]
    pub(crate) fn push(&mut self, ray: RayId, slot: LeafSlot) {
        self.pairs.push((ray, slot));
    }

    /// Adds a pair whose hit is known, and returns a reference through which to write the hit.
    /// Memory for the pair must have been reserved.
    #[inline(always)]
    pub(crate) fn push_hit(&mut self, ray: RayId, slot: LeafSlot) -> &mut Hit {
        self.push(ray, slot);
        self.hits.push(Hit::MISS);
        let last = self.hits.len() - 1;
        &mut self.hits[last]
    }

    /// Extends `hits` to the length of `pairs`, adding misses for hits that are not known yet.
    #[inline(always)]
    pub(crate) fn level(&mut self) {
        self.hits.resize(self.pairs.len(), Hit::MISS);
    }
}

/// The nearest hits of a ray so far, up to the limit, each represented by the largest t that it can
/// have. Once the limit is reached, hits beyond the largest of these values do not count.
#[derive(Default)]
pub(crate) struct NearestFew {
    /// The bit pattern of each t. The bit patterns of positive f32 values sort in the same order as
    /// the values.
    t_hi: BinaryHeap<u32>,
}

impl NearestFew {
    pub(crate) fn clear(&mut self) {
        self.t_hi.clear();
    }

    /// Adds a hit whose t is positive and at most `t_hi`. Returns the far end of the query, or
    /// `None` if memory runs out.
    pub(crate) fn add(&mut self, t_hi: f32, most: usize, far: f32) -> Option<f32> {
        if self.t_hi.len() < most {
            self.t_hi.try_reserve(1).ok()?;
            self.t_hi.push(t_hi.to_bits());
        } else if let Some(mut last) = self.t_hi.peek_mut() {
            // The top of the heap is the largest t kept; replace it if the new hit is nearer.
            *last = (*last).min(t_hi.to_bits());
        }
        // Until there are enough hits, any t up to the far end counts.
        let last = self.t_hi.peek().filter(|_| self.t_hi.len() == most);
        Some(last.map_or(far, |&last| f32::from_bits(last).min(far)))
    }
}

#[cfg(test)]
mod tests {
    use super::NearestFew;

    #[test]
    fn the_far_end_is_the_last_of_the_nearest() {
        let mut few = NearestFew::default();
        let mut far = 9.0;
        let ends = [5.0, 3.0, 4.0, 8.0, 1.0, 1.0].map(|t| {
            far = few.add(t, 3, far).unwrap();
            far
        });
        assert_eq!(ends, [9.0, 9.0, 5.0, 5.0, 4.0, 3.0]);
        few.clear();
        assert_eq!(few.add(7.0, 1, 9.0), Some(7.0));
    }
}
