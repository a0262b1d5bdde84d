//! Settles several undecided pairs side by side: the triangles of a leaf, or the rays of a packet.

use super::Resolver;
use crate::document::Tri;
use crate::exact::{EightPairs, PairDecision, Rule, Side};
use crate::simd::{Lanes, Level, Mask, Simd, WithSimd, lanes_of};
use crate::{LeafSlot, Ray, RayId, Triangle};

/// The number of undecided pairs from which it is faster to decide them side by side.
pub(crate) const SEVERAL: u32 = 3;

/// The ray and the triangle in a lane, and their ids.
type Pair = (Ray, Triangle, (RayId, LeafSlot));

impl Resolver<'_> {
    /// Decides the pairs in up to sixteen lanes like [`Resolver::decide`], but several of them side
    /// by side, and then also with 64-bit integers where f64 does not suffice.
    #[cold]
    #[inline(never)]
    pub fn decide_lanes(self, lanes: u32, pair: impl Fn(usize) -> Pair) -> [PairDecision; 16] {
        let rule = match self {
            Self::Document(_) => None,
            Self::Exact(rule) => Some(rule),
            Self::Originals(originals) => Some(originals.rule()),
        };
        if lanes.count_ones() >= SEVERAL {
            return self.decide_several(rule, lanes, pair);
        }
        let mut decisions = [PairDecision::Undecided; 16];
        for lane in lanes_of(lanes) {
            let (ray, triangle, ids) = pair(lane);
            decisions[lane] = self.decide(&ray, &triangle, ids);
        }
        decisions
    }

    /// Decides the pairs in up to sixteen lanes, eight at a time, under the given rule or, without one,
    /// with the operations of document A.
    #[inline(always)]
    fn decide_several(
        self,
        rule: Option<Rule>,
        lanes: u32,
        pair: impl Fn(usize) -> Pair,
    ) -> [PairDecision; 16] {
        let mut decisions = [PairDecision::Undecided; 16];
        let mut rest = lanes;
        while rest != 0 {
            let (mut eight, mut count) = ([0; 8], 0);
            for lane in lanes_of(rest).take(8) {
                eight[count] = lane;
                count += 1;
                rest &= rest - 1;
            }
            let some = if let (Self::Originals(originals), Some(rule)) = (self, rule) {
                let mut ids = [(RayId(0), LeafSlot(0)); 8];
                for (ids, &lane) in ids.iter_mut().zip(&eight[..count]) {
                    *ids = pair(lane).2;
                }
                originals.decide_eight(rule, &ids[..count])
            } else {
                let mut pairs = EightPairs::new();
                for (i, &lane) in eight[..count].iter().enumerate() {
                    let (ray, triangle, _) = pair(lane);
                    pairs.set(i, &ray, &triangle);
                }
                // Decisions hardly depend on the level, and answers do not depend on it.
                match (self, rule) {
                    (Self::Document(threshold), None) => {
                        Level::best().run(ByDocument { pairs: &pairs, threshold })
                    }
                    (_, rule) => pairs.decide(Level::best(), rule.unwrap_or(Rule::Closed)),
                }
            };
            for (&lane, decision) in eight[..count].iter().zip(some) {
                decisions[lane] = decision;
            }
        }
        decisions
    }

    /// Returns the lanes whose rays hit their triangles within the interval.
    #[inline(always)]
    pub fn meeting(self, lanes: u32, pair: impl Fn(usize) -> Pair) -> u32 {
        let mut hits = 0;
        if lanes.count_ones() < SEVERAL {
            for lane in lanes_of(lanes) {
                let (ray, triangle, ids) = pair(lane);
                hits |= u32::from(self.meets(&ray, &triangle, ids)) << lane;
            }
            return hits;
        }
        let decisions = self.decide_lanes(lanes, &pair);
        for lane in lanes_of(lanes) {
            let meets = match decisions[lane] {
                PairDecision::Miss => false,
                PairDecision::Hit { .. } | PairDecision::HitAt(_) => true,
                PairDecision::Undecided => {
                    let (ray, triangle, ids) = pair(lane);
                    self.meets_undecided(&ray, &triangle, ids)
                }
            };
            hits |= u32::from(meets) << lane;
        }
        hits
    }

    /// Returns the lanes whose rays cross their triangles under the *once* rule, as in
    /// [`Resolver::crossing`], and among these the lanes in which the ray leaves.
    #[cold]
    #[inline(never)]
    pub fn crossings(self, lanes: u32, pair: impl Fn(usize) -> Pair) -> [u32; 2] {
        let mut decisions = [PairDecision::Undecided; 16];
        if lanes.count_ones() >= SEVERAL {
            decisions = self.decide_several(Some(Rule::Once), lanes, &pair);
        }
        let [mut crossed, mut leaving] = [0; 2];
        for lane in lanes_of(lanes) {
            let (ray, triangle, ids) = pair(lane);
            let side = match decisions[lane] {
                PairDecision::Miss => None,
                PairDecision::Hit { .. } | PairDecision::HitAt(_) => {
                    self.facing(&ray, &triangle, ids)
                }
                PairDecision::Undecided => self.crossing(&ray, &triangle, ids),
            };
            crossed |= u32::from(side.is_some()) << lane;
            leaving |= u32::from(side == Some(Side::Leaves)) << lane;
        }
        [crossed, leaving]
    }
}

/// Eight pairs to be tested with the operations of document A.
struct ByDocument<'a> {
    pairs: &'a EightPairs<f32>,
    threshold: f64,
}

impl WithSimd for ByDocument<'_> {
    type Output = [PairDecision; 8];

    #[inline(always)]
    fn run<S: Simd>(self) -> [PairDecision; 8] {
        let (corners, rays) = self.pairs.lanes_in::<S>();
        let (hit, t) = Tri::new(corners).hit(&rays, self.threshold);
        let (hit, mut lanes) = (hit.bits(), [0.0; 8]);
        t.store(&mut lanes);
        let mut decisions = [PairDecision::Miss; 8];
        for (lane, decision) in decisions.iter_mut().enumerate() {
            if hit >> lane & 1 != 0 {
                *decision = PairDecision::HitAt(lanes[lane]);
            }
        }
        decisions
    }
}
