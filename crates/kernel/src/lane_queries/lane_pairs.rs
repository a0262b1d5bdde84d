//! Gives the resolver access to the ray and the triangle in each lane of a test.

use core::cmp::Ordering;

use crate::exact::{self, PairDecision};
use crate::packet::{RayPacket, TriangleBlock};
use crate::resolve::{Resolver, SEVERAL};
use crate::simd::lanes_of;
use crate::{LeafSlot, Ray, RayId, Triangle};

/// The ray and the triangle in each lane. The slow path, which is out of line, passes them to the
/// resolver.
pub(crate) trait LanePairs {
    /// Returns the resolver for undecided pairs.
    fn resolver(&self) -> Resolver<'_>;
    /// Returns the ray in a lane.
    fn ray(&self, lane: usize) -> Ray;
    /// Returns the triangle in a lane.
    fn triangle(&self, lane: usize) -> Triangle;
    /// Returns the id of a lane's ray and the slot of the lane's triangle.
    fn ids(&self, lane: usize) -> (RayId, LeafSlot);
    /// Returns the triangle in a slot.
    fn find(&self, slot: LeafSlot) -> Triangle;

    /// Decides a lane's pair.
    #[inline(always)]
    fn decide(&self, lane: usize) -> PairDecision {
        self.resolver().decide(&self.ray(lane), &self.triangle(lane), self.ids(lane))
    }

    /// Decides the pairs in several lanes side by side.
    #[inline(always)]
    fn decide_lanes(&self, lanes: u32) -> [PairDecision; 16] {
        let pair = |lane| (self.ray(lane), self.triangle(lane), self.ids(lane));
        self.resolver().decide_lanes(lanes, pair)
    }

    /// Returns the t of a lane's pair if it is a hit.
    #[inline(always)]
    fn hit(&self, lane: usize) -> Option<f64> {
        self.resolver().hit(&self.ray(lane), &self.triangle(lane), self.ids(lane))
    }

    /// Returns the lanes whose pairs are hits.
    #[inline(always)]
    fn meeting(&self, lanes: u32) -> u32 {
        let pair = |lane| (self.ray(lane), self.triangle(lane), self.ids(lane));
        self.resolver().meeting(lanes, pair)
    }

    /// Returns the lanes whose rays cross their triangles, and those in which the ray leaves.
    #[inline(always)]
    fn crossings(&self, lanes: u32) -> [u32; 2] {
        let pair = |lane| (self.ray(lane), self.triangle(lane), self.ids(lane));
        self.resolver().crossings(lanes, pair)
    }

    /// Returns the t of a lane's pair, which must be a hit.
    #[inline(always)]
    fn t(&self, lane: usize) -> f64 {
        self.resolver().t(&self.ray(lane), &self.triangle(lane), self.ids(lane))
    }

    /// Returns the t at which the lane's ray hits the triangle in a slot. The ray must be known to
    /// hit that triangle.
    #[inline(always)]
    fn t_in(&self, lane: usize, slot: LeafSlot) -> f64 {
        // The closest hit so far stores only its slot, so look up its triangle first.
        let (ray, _) = self.ids(lane);
        self.resolver().t(&self.ray(lane), &self.find(slot), (ray, slot))
    }

    /// Returns which of two hits comes first on the lane's ray if both values of t round to the
    /// same f64: the hit on the lane's triangle or the hit on the triangle in a slot.
    #[inline(always)]
    fn order(&self, lane: usize, slot: LeafSlot) -> Ordering {
        let (ray, here) = self.ids(lane);
        let triangles = [&self.triangle(lane), &self.find(slot)];
        self.resolver().order(&self.ray(lane), triangles, (ray, [here, slot]))
    }

    /// Returns which of two triangles, the lane's own or the one in a slot, comes first on the
    /// lane's ray, if their coordinates alone tell. The ray must hit the one in the slot; if it
    /// misses the other, the result is meaningless.
    #[inline(always)]
    fn order_by_coordinates(&self, lane: usize, slot: LeafSlot) -> Option<Ordering> {
        // Pass a closure, because most resolvers decide without loading the triangles.
        let pair = || (self.ray(lane), [self.triangle(lane), self.find(slot)]);
        let (ray, here) = self.ids(lane);
        self.resolver().order_by_coordinates(pair, (ray, [here, slot]))
    }

    /// Returns whether the corner or the edge on which the lane's ray meets the triangle in one slot
    /// also belongs to the triangle in another. If the ray hits both, t is then the same.
    #[inline(always)]
    fn shares_feature(&self, lane: usize, (one, edges): (LeafSlot, u8), other: LeafSlot) -> bool {
        let pair = || [self.find(one), self.find(other)];
        self.resolver().shares_feature(pair, edges, (self.ids(lane).0, [one, other]))
    }

    /// Like [`LanePairs::shares_feature`], for the triangle in a slot and those in several lanes with
    /// the same ray. Returns the lanes that share the corner or the edge.
    #[inline(always)]
    fn sharing(&self, lanes: u32, (one, edges): (LeafSlot, u8)) -> u32 {
        let select = |shares: &dyn Fn(usize) -> bool| {
            lanes_of(lanes).filter(|lane| shares(*lane)).fold(0, |bits, lane| bits | 1 << lane)
        };
        match self.resolver() {
            Resolver::Document(_) => 0,
            Resolver::Exact(_) if lanes != 0 => {
                let met = self.find(one);
                select(&|lane| exact::shares_feature(&met, edges, &self.triangle(lane)))
            }
            _ => select(&|lane| self.shares_feature(lane, (one, edges), self.ids(lane).1)),
        }
    }

    /// Returns which of two triangles, the lane's own or the one in a slot, comes first on the
    /// lane's ray, if that is known without an exact t. If the ray misses one of the triangles,
    /// the result is meaningless.
    #[inline(always)]
    fn known_order(&self, lane: usize, slot: LeafSlot) -> Option<Ordering> {
        let pair = || (self.ray(lane), [self.triangle(lane), self.find(slot)]);
        let (ray, here) = self.ids(lane);
        self.resolver().known_order(pair, (ray, [here, slot]))
    }
}

/// The decisions that were made about several lanes side by side.
pub(super) struct DecidedLanes {
    lanes: u32,
    decisions: [PairDecision; 16],
}

impl DecidedLanes {
    /// Decides the pairs in the given lanes, if there are several.
    #[inline(always)]
    pub(super) fn of(undecided: u32, pairs: &impl LanePairs) -> Self {
        if undecided.count_ones() < SEVERAL {
            return Self { lanes: 0, decisions: [PairDecision::Miss; 16] };
        }
        Self { lanes: undecided, decisions: pairs.decide_lanes(undecided) }
    }

    /// Returns the decision about a lane, if it was one of several.
    #[inline(always)]
    pub(super) fn get(&self, lane: usize) -> Option<PairDecision> {
        (self.lanes >> lane & 1 != 0).then(|| self.decisions[lane])
    }
}

/// A packet of rays in lanes, with one triangle.
pub(crate) struct RaysOnTriangle<'a, P, const N: usize> {
    pub(crate) resolver: Resolver<'a>,
    pub(crate) packet: &'a RayPacket<N>,
    /// The id of the packet's first ray.
    pub(crate) first: RayId,
    pub(crate) triangle: &'a Triangle,
    /// The triangle's slot.
    pub(crate) slot: LeafSlot,
    pub(crate) find: P,
}

impl<P: Fn(LeafSlot) -> Triangle, const N: usize> LanePairs for RaysOnTriangle<'_, P, N> {
    #[inline(always)]
    fn resolver(&self) -> Resolver<'_> {
        self.resolver
    }
    #[inline(always)]
    fn ray(&self, lane: usize) -> Ray {
        self.packet.ray(lane)
    }
    #[inline(always)]
    fn triangle(&self, _lane: usize) -> Triangle {
        *self.triangle
    }
    #[inline(always)]
    fn ids(&self, lane: usize) -> (RayId, LeafSlot) {
        // Rays are numbered consecutively.
        (RayId(self.first.0 + lane as u32), self.slot)
    }
    #[inline(always)]
    fn find(&self, slot: LeafSlot) -> Triangle {
        (self.find)(slot)
    }
}

/// A block of triangles in lanes, with one ray.
pub(crate) struct RayOnBlock<'a, P, const N: usize> {
    pub(crate) resolver: Resolver<'a>,
    pub(crate) ray: &'a Ray,
    pub(crate) id: RayId,
    pub(crate) block: &'a TriangleBlock<N>,
    /// The slot of the block's first triangle.
    pub(crate) first: LeafSlot,
    pub(crate) find: P,
}

impl<P: Fn(LeafSlot) -> Triangle, const N: usize> LanePairs for RayOnBlock<'_, P, N> {
    #[inline(always)]
    fn resolver(&self) -> Resolver<'_> {
        self.resolver
    }
    #[inline(always)]
    fn ray(&self, _lane: usize) -> Ray {
        *self.ray
    }
    #[inline(always)]
    fn triangle(&self, lane: usize) -> Triangle {
        self.block.triangle(lane)
    }
    #[inline(always)]
    fn ids(&self, lane: usize) -> (RayId, LeafSlot) {
        (self.id, LeafSlot(self.first.0 + lane as u32))
    }
    #[inline(always)]
    fn find(&self, slot: LeafSlot) -> Triangle {
        (self.find)(slot)
    }
}

/// A row of triangles in lanes, with one ray.
pub(crate) struct RayOnRow<'a, P> {
    pub(crate) resolver: Resolver<'a>,
    pub(crate) ray: &'a Ray,
    /// The slot of the row's first triangle.
    pub(crate) first: LeafSlot,
    pub(crate) find: P,
}

impl<P: Fn(LeafSlot) -> Triangle> LanePairs for RayOnRow<'_, P> {
    #[inline(always)]
    fn resolver(&self) -> Resolver<'_> {
        self.resolver
    }
    #[inline(always)]
    fn ray(&self, _lane: usize) -> Ray {
        *self.ray
    }
    #[inline(always)]
    fn triangle(&self, lane: usize) -> Triangle {
        // A row is loaded directly from the caller's slice and not stored, so look the triangle up
        // in the slice again.
        (self.find)(LeafSlot(self.first.0 + lane as u32))
    }
    #[inline(always)]
    fn ids(&self, lane: usize) -> (RayId, LeafSlot) {
        (RayId(0), LeafSlot(self.first.0 + lane as u32))
    }
    #[inline(always)]
    fn find(&self, slot: LeafSlot) -> Triangle {
        (self.find)(slot)
    }
}
