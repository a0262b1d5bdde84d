//! Undecided pairs of N rays and several triangles, collected so that they can be decided side by side.
//!
//! ```text
//!   triangle 7    ray 2, ray 9         A triangle rarely leaves more than one or two of a packet's rays
//!   triangle 8    ray 2                undecided, too few to fill lanes. Hits may be found in any order,
//!   triangle 12   ray 5, ray 6, ...    so the pairs of several triangles can wait for each other.
//! ```

use super::closest_hit::ClosestHit;
use super::closest_hits::ClosestHits;
use super::lane_pairs::RaysOnTriangle;
use crate::packet::RayPacket;
use crate::resolve::Resolver;
use crate::simd::{Lanes, lanes_of};
use crate::{LeafSlot, RayId, Triangle, TriangleId};

/// The number of pairs to decide together.
const TOGETHER: usize = 8;

/// The largest number of pairs, one triangle with all rays of a packet and those that wait.
const MOST: usize = TOGETHER + 16;

/// Pairs of up to sixteen rays and several triangles.
pub(crate) struct OpenLanes {
    pairs: [(u32, TriangleId, LeafSlot); MOST],
    len: usize,
}

impl OpenLanes {
    /// Creates an empty collection.
    #[inline(always)]
    pub(crate) fn new() -> Self {
        Self { pairs: [(0, TriangleId::NONE, LeafSlot(0)); MOST], len: 0 }
    }

    /// Returns whether no pair waits.
    #[inline(always)]
    pub(crate) fn is_empty(&self) -> bool {
        self.len == 0
    }

    /// Adds the pairs of a triangle and the rays in the given lanes. Returns whether there are now
    /// enough pairs to be decided; if there are, [`OpenLanes::settle`] must be called next.
    #[inline(always)]
    pub(crate) fn add(&mut self, lanes: u32, (triangle, slot): (TriangleId, LeafSlot)) -> bool {
        for lane in lanes_of(lanes) {
            self.pairs[self.len % MOST] = (lane as u32, triangle, slot);
            self.len += 1;
        }
        self.len >= TOGETHER
    }

    /// Decides all pairs and offers them to the closest hits.
    #[inline(always)]
    pub(crate) fn settle<F: Lanes<Scalar = f32>, const N: usize>(
        &mut self,
        resolver: Resolver<'_>,
        packet: &RayPacket<N>,
        find: impl Fn(LeafSlot) -> Triangle,
        closest: &mut ClosestHits<F, N>,
    ) {
        // Registers are read and written here, because the function that is out of line has none as wide.
        let mut all = closest.lanes();
        self.settle_each(resolver, packet, find, &mut all);
        closest.set_all(&all);
    }

    #[cold]
    #[inline(never)]
    fn settle_each<const N: usize>(
        &mut self,
        resolver: Resolver<'_>,
        packet: &RayPacket<N>,
        find: impl Fn(LeafSlot) -> Triangle,
        all: &mut [ClosestHit; N],
    ) {
        for pairs in self.pairs[..self.len.min(MOST)].chunks(TOGETHER) {
            let decisions = resolver.decide_lanes(
                (1 << pairs.len()) - 1,
                #[inline(always)]
                |i| {
                    let (lane, _, slot) = pairs[i];
                    (packet.ray(lane as usize), find(slot), (RayId(lane), slot))
                },
            );
            for (&(lane, id, slot), decision) in pairs.iter().zip(&decisions) {
                let triangle = &find(slot);
                let first = RayId(0);
                let on = RaysOnTriangle { resolver, packet, first, triangle, slot, find: &find };
                all[lane as usize % N].offer_decided(*decision, (id, slot), lane as usize, &on);
            }
        }
        self.len = 0;
    }
}
