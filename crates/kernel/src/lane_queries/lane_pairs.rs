//! The pairs of a ray and a triangle behind the lanes of a test, for the resolver.

use core::cmp::Ordering;

use crate::packet::{RayPacket, TriangleBlock};
use crate::resolve::Resolver;
use crate::{LeafSlot, Ray, RayId, Triangle};

/// The pair of a ray and a triangle behind each lane. The slow path, out of line, passes it to the resolver.
pub(crate) trait LanePairs {
    /// The resolver of undecided pairs.
    fn resolver(&self) -> Resolver<'_>;
    /// The ray of a lane.
    fn ray(&self, lane: usize) -> Ray;
    /// The triangle of a lane.
    fn triangle(&self, lane: usize) -> Triangle;
    /// The ids of the ray and of the slot of a lane.
    fn ids(&self, lane: usize) -> (RayId, LeafSlot);
    /// The triangle in a slot.
    fn find(&self, slot: LeafSlot) -> Triangle;

    /// t, if the pair of a lane is a hit.
    #[inline(always)]
    fn hit(&self, lane: usize) -> Option<f64> {
        self.resolver().hit(&self.ray(lane), &self.triangle(lane), self.ids(lane))
    }

    /// Whether the pair of a lane is a hit.
    #[inline(always)]
    fn meets(&self, lane: usize) -> bool {
        self.resolver().meets(&self.ray(lane), &self.triangle(lane), self.ids(lane))
    }

    /// t for the pair of a lane, which is known to be a hit.
    #[inline(always)]
    fn t(&self, lane: usize) -> f64 {
        self.resolver().t(&self.ray(lane), &self.triangle(lane), self.ids(lane))
    }

    /// t for the lane's ray and the triangle in a slot, which it is known to hit.
    #[inline(always)]
    fn t_in(&self, lane: usize, slot: LeafSlot) -> f64 {
        // The best hit so far stores only its slot, so find its triangle first.
        let (ray, _) = self.ids(lane);
        self.resolver().t(&self.ray(lane), &self.find(slot), (ray, slot))
    }

    /// Which of two hits of a lane with equal rounded t comes first: the lane's triangle, or the one in a
    /// slot.
    #[inline(always)]
    fn order(&self, lane: usize, slot: LeafSlot) -> Ordering {
        let (ray, here) = self.ids(lane);
        let triangles = [&self.triangle(lane), &self.find(slot)];
        self.resolver().order(&self.ray(lane), triangles, (ray, [here, slot]))
    }

    /// Whether the triangle of a lane and the one in a slot touch where the lane's ray meets them, if it hits both.
    #[inline(always)]
    fn touch(&self, lane: usize, slot: LeafSlot) -> bool {
        // A closure, because most resolvers answer without loading the triangles.
        let pair = || (self.ray(lane), [self.triangle(lane), self.find(slot)]);
        let (ray, here) = self.ids(lane);
        self.resolver().touch(pair, (ray, [here, slot]))
    }
}

/// The lanes of a packet of rays, with one triangle.
pub(crate) struct RaysOnTriangle<'a, P, const N: usize> {
    pub(crate) resolver: Resolver<'a>,
    pub(crate) packet: &'a RayPacket<N>,
    /// The number of its first ray.
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

/// The lanes of a block of triangles with one ray.
pub(crate) struct RayOnBlock<'a, P, const N: usize> {
    pub(crate) resolver: Resolver<'a>,
    pub(crate) ray: &'a Ray,
    pub(crate) id: RayId,
    pub(crate) block: &'a TriangleBlock<N>,
    /// The slot of its first triangle.
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

/// The lanes of a row of triangles with one ray.
pub(crate) struct RayOnRow<'a, P> {
    pub(crate) resolver: Resolver<'a>,
    pub(crate) ray: &'a Ray,
    /// The slot of its first triangle.
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
        // A row is loaded directly from the caller's slice and not stored, so the triangle is looked up there
        // again.
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
