//! The closest hit of one ray so far. Two hits are compared by their f32 intervals of t. If the
//! intervals overlap, the hits are compared by t in f64, and if those values are equal, by the
//! resolver.

use core::cmp::Ordering;

use super::lane_pairs::{DecidedLanes, LanePairs};
use crate::exact::{PairDecision, f32_bounds};
use crate::filter::Verdicts;
use crate::simd::{Lanes, Mask, lanes_of};
use crate::{LeafSlot, TriangleId};

/// The closest hit of one ray so far.
///
/// The mode's t is in `t_lo..=t_hi`. Two hits are compared by these intervals. If the intervals
/// overlap, the hits are compared by t in f64, and if those values are equal, by the resolver. If
/// both hits have the same t, the lower index wins.
///
/// See [`Filter::closest_in`](crate::Filter::closest_in) for an example.
///
/// ```
/// use intertri::ClosestHit;
/// let closest = ClosestHit::new(9.0);
/// assert_eq!((closest.is_hit(), closest.triangle(), closest.t_hi()), (false, None, 9.0));
/// ```
#[derive(Clone, Copy, Debug)]
pub struct ClosestHit {
    /// t in f64; NaN until it is needed. The lowest bits of the NaN are the edges on which the ray is
    /// known to meet the triangle, as in [`PairDecision::Hit`].
    pub(super) t: f64,
    pub(super) t_lo: f32,
    pub(super) t_hi: f32,
    /// [`TriangleId::NONE`] before the first hit.
    pub(super) triangle: TriangleId,
    pub(super) slot: LeafSlot,
}

impl ClosestHit {
    /// Creates a record with no hit yet: any hit before `t_max` is closer.
    #[inline(always)]
    pub fn new(t_max: f32) -> Self {
        Self {
            t: f64::from(t_max),
            t_lo: t_max,
            t_hi: t_max,
            triangle: TriangleId::NONE,
            slot: LeafSlot(0),
        }
    }

    /// Creates a record with no hit yet, for a far end that is known only to be between `sure` and
    /// `t_max`.
    #[inline(always)]
    pub(crate) fn before(sure: f32, t_max: f32) -> Self {
        Self { t_lo: sure, ..Self::new(t_max) }
    }

    /// Returns an upper bound on t: no hit beyond it can become the closest.
    #[inline(always)]
    pub fn t_hi(&self) -> f32 {
        self.t_hi
    }

    /// Returns whether there is a hit.
    #[inline(always)]
    pub fn is_hit(&self) -> bool {
        self.triangle != TriangleId::NONE
    }

    /// Returns the index of the closest triangle, and the slot in which the caller stores it.
    #[inline(always)]
    pub fn triangle(&self) -> Option<(TriangleId, LeafSlot)> {
        self.is_hit().then_some((self.triangle, self.slot))
    }

    /// Offers a lane's hit whose t is known.
    #[inline(always)]
    fn offer_known(
        &mut self,
        t: f64,
        new: (TriangleId, LeafSlot),
        lane: usize,
        pairs: &impl LanePairs,
    ) {
        let (triangle, slot) = new;
        let (t_lo, t_hi) = f32_bounds(t);
        // Before the first hit, there is nothing to compare with: the far end has already been
        // checked.
        let closer = !self.is_hit()
            || t_hi < self.t_lo
            || t_lo <= self.t_hi && self.is_beaten_by(t, triangle, lane, pairs);
        if closer {
            *self = Self { t, t_lo, t_hi, triangle, slot };
        }
    }

    /// Offers a lane's hit whose t is in `t_lo..=t_hi`. The hit may be beyond the far end of the
    /// ray.
    #[inline(always)]
    fn offer_near(
        &mut self,
        (t_lo, t_hi): (f32, f32),
        new: (TriangleId, LeafSlot),
        lane: usize,
        pairs: &impl LanePairs,
    ) {
        if t_hi < self.t_lo {
            // The new hit is certainly in front of the old hit.
            self.replace((t_lo, t_hi), new, 0);
        } else if t_lo <= self.t_hi {
            if self.is_hit() {
                // Coplanar walls are common, and their order can be determined without arithmetic.
                // Most of the others differ enough for f64.
                let order = pairs.known_order(lane, self.slot);
                self.offer_rival((t_lo, t_hi), order, (new, 0), lane, pairs);
            } else {
                // The interval overlaps the far end of the ray, so the resolver must also check the
                // far end.
                self.offer_undecided(new, lane, pairs);
            }
        }
    }

    /// Stores a hit that is in front of the closest hit so far. Its t is NaN until another hit
    /// comes close and the exact value is needed. The ray is known to meet the triangle on `edges`.
    #[inline(always)]
    fn replace(&mut self, (t_lo, t_hi): (f32, f32), new: (TriangleId, LeafSlot), edges: u8) {
        let (triangle, slot) = new;
        *self = Self { t: unknown(edges), t_lo, t_hi, triangle, slot };
    }

    /// Offers a lane's hit whose interval of t overlaps that of the closest hit so far. `order` is
    /// the order of the two hits, if it is known.
    #[inline(always)]
    fn offer_rival(
        &mut self,
        (t_lo, t_hi): (f32, f32),
        order: Option<Ordering>,
        (new, edges): ((TriangleId, LeafSlot), u8),
        lane: usize,
        pairs: &impl LanePairs,
    ) {
        let Some(order) = order else {
            return self.offer_known(pairs.t(lane), new, lane, pairs);
        };
        if order.then(new.0.cmp(&self.triangle)).is_lt() {
            // The new hit's t is at most the t of the closest hit so far.
            let t_hi = if t_hi < self.t_hi { t_hi } else { self.t_hi };
            self.replace((t_lo, t_hi), new, edges);
        }
    }

    /// Returns the edges on which the ray is known to meet the triangle, if t is not known.
    #[inline(always)]
    fn edges(&self) -> u8 {
        if self.t.is_nan() { (self.t.to_bits() & 0b111) as u8 } else { 0 }
    }

    /// Offers a lane's pair that the filter left undecided. The function is out of line to keep
    /// registers free for the common case.
    #[cold]
    #[inline(never)]
    fn offer_undecided(
        &mut self,
        new: (TriangleId, LeafSlot),
        lane: usize,
        pairs: &impl LanePairs,
    ) {
        // Walls and floors can often be ordered without arithmetic. If the triangle is behind the
        // closest hit, or has the same t and a higher index, it does not matter whether it is hit.
        if self.is_hit()
            && let Some(order) = pairs.order_by_coordinates(lane, self.slot)
            && order.then(new.0.cmp(&self.triangle)).is_gt()
        {
            return;
        }
        self.offer_decided(pairs.decide(lane), new, lane, pairs);
    }

    /// Offers a lane's pair about which this has been decided.
    #[cold]
    #[inline(never)]
    pub(super) fn offer_decided(
        &mut self,
        decision: PairDecision,
        new: (TriangleId, LeafSlot),
        lane: usize,
        pairs: &impl LanePairs,
    ) {
        // The exact t is not needed unless another hit is about as far away.
        match decision {
            PairDecision::Miss => {}
            // Without an upper bound on t, no box behind the hit could be left out.
            PairDecision::Hit { t_hi: f32::INFINITY, .. } if !self.is_hit() => {
                self.offer_known(pairs.t(lane), new, lane, pairs);
            }
            PairDecision::Hit { t_lo, t_hi, edges } => {
                if !self.is_hit() || t_hi < self.t_lo {
                    self.replace((t_lo, t_hi), new, edges);
                } else if t_lo <= self.t_hi {
                    let met = (new.1, edges);
                    let order = if edges != 0 && pairs.shares_feature(lane, met, self.slot) {
                        Some(Ordering::Equal)
                    } else {
                        pairs.known_order(lane, self.slot)
                    };
                    self.offer_rival((t_lo, t_hi), order, (new, edges), lane, pairs);
                }
            }
            PairDecision::HitAt(t) => self.offer_known(t, new, lane, pairs),
        }
    }

    /// Offers the filter's verdict on a lane whose triangle has the given id and slot.
    #[inline(always)]
    pub(super) fn offer_lane<F: Lanes<Scalar = f32>>(
        &mut self,
        verdicts: &Verdicts<F>,
        new: (TriangleId, LeafSlot),
        lane: usize,
        pairs: &impl LanePairs,
    ) {
        if verdicts.hit >> lane & 1 != 0 {
            let (mut t_lo, mut t_hi) = ([0.0; 16], [0.0; 16]);
            verdicts.t_lo.store(&mut t_lo);
            verdicts.t_hi.store(&mut t_hi);
            self.offer_near((t_lo[lane], t_hi[lane]), new, lane, pairs);
        } else {
            self.offer_undecided(new, lane, pairs);
        }
    }

    /// Offers the filter's verdicts on a block of triangles. Triangle i has the index `indices[i]`
    /// and the slot `slot + i`.
    #[inline(always)]
    pub(crate) fn offer_block<F: Lanes<Scalar = f32>>(
        &mut self,
        verdicts: &Verdicts<F>,
        indices: &[u32; 8],
        slot: LeafSlot,
        pairs: &impl LanePairs,
    ) {
        if verdicts.lanes() == 0 {
            return;
        }

        // Among the certain hits, find the hit whose interval ends first, and all hits whose
        // intervals begin before that end.
        let hit = F::Mask::from_bits(verdicts.hit);
        let ends = F::select(hit, verdicts.t_hi, F::splat(f32::INFINITY));
        let (mut t_lo, mut t_hi) = ([0.0; 8], [0.0; 8]);
        verdicts.t_lo.store(&mut t_lo);
        ends.store(&mut t_hi);
        let first = least(&t_hi);
        let rivals = (hit & verdicts.t_lo.le(F::splat(first))).bits();

        // `rivals` nearly always contains only one lane, which is certain to win.
        // `rivals & (rivals - 1)` clears the lowest bit, which leaves the other rivals.
        let doubtful = rivals & rivals.wrapping_sub(1) | verdicts.undecided;
        if doubtful == 0 && first < self.t_lo {
            let lane = rivals.trailing_zeros() as usize % 8;
            let (triangle, slot) = lane_names(indices, slot, lane);
            self.replace((t_lo[lane], first), (triangle, slot), 0);
            return;
        }
        let (lanes, hit) = (verdicts.lanes(), verdicts.hit);
        let lanes = OneByOne { lanes, hit, t_lo: &t_lo, t_hi: &t_hi };
        self.offer_one_by_one(&lanes, |lane| lane_names(indices, slot, lane), pairs);
    }

    /// Offers the filter's verdicts on a row of triangles. Triangle i has the index and the slot
    /// `first + i`.
    #[inline(always)]
    pub(crate) fn offer_row<F: Lanes<Scalar = f32>>(
        &mut self,
        verdicts: &Verdicts<F>,
        first: LeafSlot,
        pairs: &impl LanePairs,
    ) {
        let (mut t_lo, mut t_hi) = ([0.0; 16], [0.0; 16]);
        verdicts.t_lo.store(&mut t_lo);
        verdicts.t_hi.store(&mut t_hi);
        let (lanes, hit) = (verdicts.lanes(), verdicts.hit);
        let lanes = OneByOne { lanes, hit, t_lo: &t_lo, t_hi: &t_hi };
        self.offer_one_by_one(
            &lanes,
            |lane| (TriangleId(first.0 + lane as u32), LeafSlot(first.0 + lane as u32)),
            pairs,
        );
    }

    /// Offers the filter's verdicts lane by lane. The function is out of line to keep registers
    /// free for the common case.
    #[inline(never)]
    fn offer_one_by_one(
        &mut self,
        verdicts: &OneByOne<'_>,
        names: impl Fn(usize) -> (TriangleId, LeafSlot),
        pairs: &impl LanePairs,
    ) {
        let mut lanes = verdicts.lanes;
        if self.edges() != 0 {
            lanes &= !self.later_at_edges(lanes, &names, pairs);
        }
        let decided = DecidedLanes::of(lanes & !verdicts.hit, pairs);
        for lane in lanes_of(lanes) {
            self.offer_one(verdicts, &decided, names(lane), lane, pairs);
        }
    }

    /// Returns the lanes with triangles that also have the corner or the edge at which the ray meets the
    /// closest triangle so far, and a higher index. They cannot become the closest.
    #[cold]
    #[inline(never)]
    fn later_at_edges(
        &self,
        lanes: u32,
        names: &impl Fn(usize) -> (TriangleId, LeafSlot),
        pairs: &impl LanePairs,
    ) -> u32 {
        let later = lanes_of(lanes).filter(|lane| names(*lane).0 > self.triangle);
        let later = later.fold(0, |bits, lane| bits | 1 << lane);
        pairs.sharing(later, (self.slot, self.edges()))
    }

    /// Offers the verdict on one lane.
    #[inline(always)]
    pub(super) fn offer_one(
        &mut self,
        verdicts: &OneByOne<'_>,
        decided: &DecidedLanes,
        new: (TriangleId, LeafSlot),
        lane: usize,
        pairs: &impl LanePairs,
    ) {
        if let Some(decision) = decided.get(lane) {
            self.offer_decided(decision, new, lane, pairs);
        } else if verdicts.hit >> lane & 1 != 0 {
            self.offer_near((verdicts.t_lo[lane], verdicts.t_hi[lane]), new, lane, pairs);
        } else {
            self.offer_undecided(new, lane, pairs);
        }
    }

    /// Returns whether a lane's hit with this t and index comes before the closest hit so far.
    #[inline(always)]
    fn is_beaten_by(
        &mut self,
        t: f64,
        triangle: TriangleId,
        lane: usize,
        pairs: &impl LanePairs,
    ) -> bool {
        if self.t.is_nan() {
            // The t of the closest hit so far is computed only when another hit comes close, and is
            // then stored.
            self.t = pairs.t_in(lane, self.slot);
        }
        let order = if t == self.t { pairs.order(lane, self.slot) } else { Ordering::Equal };
        t < self.t || t == self.t && order.then(triangle.cmp(&self.triangle)).is_lt()
    }
}

/// The bits of a quiet NaN.
const NAN: u64 = 0x7ff8 << 48;

/// Returns a NaN for a hit whose t is not known, on a triangle that the ray meets on `edges`.
#[inline(always)]
pub(super) fn unknown(edges: u8) -> f64 {
    f64::from_bits(NAN | u64::from(edges))
}

/// The filter's verdicts on lanes, stored so that they can be processed one by one.
pub(super) struct OneByOne<'a> {
    pub(super) lanes: u32,
    pub(super) hit: u32,
    pub(super) t_lo: &'a [f32],
    pub(super) t_hi: &'a [f32],
}

/// Returns the index and the slot of the triangle in a lane of a block. `slot` is the slot of the
/// first lane.
#[inline(always)]
fn lane_names(indices: &[u32; 8], LeafSlot(slot): LeafSlot, lane: usize) -> (TriangleId, LeafSlot) {
    (TriangleId(indices[lane]), LeafSlot(slot + lane as u32))
}

/// Returns the smallest of eight values.
#[inline(always)]
fn least(of: &[f32; 8]) -> f32 {
    // `if b < a` is one instruction; `f32::min` would also have to handle NaN.
    let less = |a: f32, b: f32| if b < a { b } else { a };
    let [a, b, c, d, e, f, g, h] = *of;
    less(less(less(a, e), less(b, f)), less(less(c, g), less(d, h)))
}

#[cfg(test)]
mod tests;
