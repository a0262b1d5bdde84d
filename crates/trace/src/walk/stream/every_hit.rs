//! Collects every hit of a stream's rays, leaf by leaf. The result is a list of hit pairs, the
//! number of crossings of each ray, or the winding number around each ray's origin.

use intertri::internal::BlockHits;
use intertri::internal::exact::{PairDecision, Side};
use intertri::{Crossings, Filter, LeafSlot, Ray, RayId};

use crate::containment::Containment;
use crate::tree::Tree;
use crate::util::lane_ops::lanes_of;
use crate::walk::BatchOutput;
use crate::walk::single::is_held;
use crate::walk::{HitPairs, NearestFew};

/// Collects all hits of one ray in a stream.
pub(super) struct HitCollector<'a> {
    pub(super) tree: &'a Tree,
    pub(super) filter: Filter<'a>,
    pub(super) id: RayId,
    pub(super) ray: &'a Ray,
    /// The ray's nearest hits, if the number of hits is limited.
    pub(super) few: Option<&'a mut NearestFew>,
    pub(super) far: f32,
}

impl HitCollector<'_> {
    /// Collects the hits of a leaf. Returns whether the ray is done.
    #[inline(always)]
    pub(super) fn take(
        &mut self,
        hits: &BlockHits,
        leaf: usize,
        output: &mut BatchOutput<'_>,
    ) -> bool {
        match output {
            BatchOutput::Pairs(pairs) => self.pairs(hits, leaf, pairs),
            BatchOutput::Crossings(all) => {
                self.crossings(hits, leaf, &mut all[self.id.0 as usize]);
                false
            }
            BatchOutput::Containments(all) => {
                self.winding(hits, leaf, &mut all[self.id.0 as usize])
            }
            BatchOutput::Hits(_)
            | BatchOutput::Hits32(_)
            | BatchOutput::Triangles(_)
            | BatchOutput::Any(_) => false,
        }
    }

    /// Adds the hits to `pairs`. Returns whether the ray is done.
    #[inline(always)]
    fn pairs(&mut self, hits: &BlockHits, leaf: usize, pairs: &mut HitPairs) -> bool {
        // A leaf has at most eight hits. Reserve memory for all of them first, so that `push`
        // cannot fail halfway through.
        if !pairs.reserve(8) {
            return true;
        }
        let (first, id) = (8 * leaf, self.id);
        for lane in lanes_of(hits.sure) {
            pairs.push(id, LeafSlot((first + lane) as u32));
        }
        let is_limited = self.few.is_some();
        hits.undecided != 0 && self.settle(hits.undecided, first, pairs)
            || is_limited && self.shorten(hits, pairs)
    }

    /// Adds the undecided lanes that the resolver confirms as hits. Returns whether the ray is
    /// done.
    #[cold]
    #[inline(never)]
    fn settle(&mut self, undecided: u32, first: usize, pairs: &mut HitPairs) -> bool {
        let resolver = self.filter.resolver();
        let pair = |lane: usize| {
            let slot = LeafSlot((first + lane) as u32);
            (*self.ray, self.tree.triangle_in(slot), (self.id, slot))
        };
        let Some(most) = pairs.limit else {
            for lane in lanes_of(resolver.meeting(undecided, pair)) {
                pairs.push(self.id, LeafSlot((first + lane) as u32));
            }
            return false;
        };
        let decisions = resolver.decide_lanes(undecided, pair);
        for lane in lanes_of(undecided) {
            let t_hi = match decisions[lane] {
                PairDecision::Miss => continue,
                PairDecision::Hit { t_hi, .. } => t_hi,
                // This must also be an upper bound on t, so that the new far end does not exclude this
                // hit itself.
                PairDecision::HitAt(t) => (t as f32).next_up(),
            };
            pairs.push(self.id, LeafSlot((first + lane) as u32));
            if let Some(few) = &mut self.few {
                match few.add(t_hi, most, self.far) {
                    Some(far) => self.far = far,
                    None => pairs.is_full = true,
                }
            }
        }
        pairs.is_full
    }

    /// If the number of hits is limited, shortens the ray to the last hit that can still count.
    /// Returns whether the ray is done.
    #[inline(never)]
    fn shorten(&mut self, hits: &BlockHits, pairs: &mut HitPairs) -> bool {
        if let (Some(few), Some(most)) = (&mut self.few, pairs.limit) {
            for lane in lanes_of(hits.sure) {
                // Use the upper bound on this hit's t: the new far end may exclude only hits that
                // are certainly behind all kept hits.
                match few.add(hits.t_hi[lane % 8], most, self.far) {
                    Some(far) => self.far = far,
                    None => pairs.is_full = true,
                }
            }
        }
        pairs.is_full
    }

    /// Counts the crossings. A ray that certainly passes inside all edges crosses the triangle;
    /// near an edge, the exact rule decides.
    #[inline(always)]
    fn crossings(&self, hits: &BlockHits, leaf: usize, crossings: &mut Crossings) {
        for lane in lanes_of(hits.sure) {
            // If a ray passes strictly inside all edges, a hit is always a crossing, and the filter
            // has already determined its side (exact.md, section 9).
            crossings.add(hits.leaves >> lane & 1 != 0);
        }
        if hits.undecided != 0 {
            let [crossed, leaving] = self.crossed_among(hits.undecided, leaf);
            lanes_of(crossed).for_each(|lane| crossings.add(leaving >> lane & 1 != 0));
        }
    }

    /// Updates the winding number around the ray's origin. Returns whether the origin is on a
    /// triangle. In that case, the filter leaves the pair undecided: the numerator of t is 0, and
    /// no edge value proves a miss.
    #[inline(always)]
    fn winding(&self, hits: &BlockHits, leaf: usize, containment: &mut Containment) -> bool {
        for lane in lanes_of(hits.sure) {
            *containment = containment.crossed(hits.leaves >> lane & 1 != 0);
        }
        if hits.undecided == 0 {
            return false;
        }
        if lanes_of(hits.undecided).any(|lane| self.starts_on(LeafSlot((8 * leaf + lane) as u32))) {
            // A point on the surface is neither inside nor outside, regardless of the crossings
            // counted so far.
            *containment = Containment::Surface;
            return true;
        }
        let [crossed, leaving] = self.crossed_among(hits.undecided, leaf);
        for lane in lanes_of(crossed) {
            *containment = containment.crossed(leaving >> lane & 1 != 0);
        }
        false
    }

    /// Returns which of a leaf's undecided triangles the ray crosses, and which of these it leaves.
    #[inline(always)]
    fn crossed_among(&self, undecided: u32, leaf: usize) -> [u32; 2] {
        let pair = |lane: usize| {
            let slot = LeafSlot((8 * leaf + lane) as u32);
            (*self.ray, self.tree.triangle_in(slot), (self.id, slot))
        };
        self.filter.resolver().crossings(undecided, pair)
    }

    /// Returns the side from which the ray crosses the triangle in a slot, or `None` if it does not
    /// cross the triangle.
    #[inline(always)]
    fn crossed(&self, slot: LeafSlot) -> Option<Side> {
        let triangle = self.tree.triangle_in(slot);
        self.filter.resolver().crossing(self.ray, &triangle, (self.id, slot))
    }

    /// Returns whether the ray starts on the triangle in a slot.
    #[inline(always)]
    fn starts_on(&self, slot: LeafSlot) -> bool {
        let triangle = self.tree.triangle_in(slot);
        self.filter.resolver().starts_on(self.ray, &triangle, (self.id, slot))
    }

    /// Collects all hits of a ray that was traced alone, given the slots of the triangles that it
    /// hits.
    pub(super) fn take_alone(&mut self, slots: &[LeafSlot], output: &mut BatchOutput<'_>) {
        let number = self.id.0 as usize;
        let crossed = |slot: &LeafSlot| self.crossed(*slot);
        let leaves = slots.iter().filter_map(crossed).map(|side| side == Side::Leaves);
        match output {
            BatchOutput::Pairs(pairs) => {
                if pairs.reserve(slots.len()) {
                    for &slot in slots {
                        pairs.push(self.id, slot);
                    }
                }
            }
            BatchOutput::Crossings(all) => leaves.for_each(|leaves| all[number].add(leaves)),
            BatchOutput::Containments(all) => {
                let starts_on = |slot| self.starts_on(slot);
                // Tracing a ray alone finds only hits with t > 0, so test separately whether the
                // ray starts on a triangle.
                all[number] = if is_held(self.tree, self.ray.origin, starts_on) {
                    Containment::Surface
                } else {
                    leaves.fold(all[number], Containment::crossed)
                };
            }
            BatchOutput::Hits(_)
            | BatchOutput::Hits32(_)
            | BatchOutput::Triangles(_)
            | BatchOutput::Any(_) => (),
        }
    }
}
