//! The pairs of a ray and a triangle that the lanes of one test stand for, for the resolver.

use core::cmp::Ordering;

use crate::packet::{RayPacket, TriangleBlock};
use crate::resolve::Resolver;
use crate::{Ray, Triangle};

/// What a lane's turn comes to when it is asked for, out of line. A *place* is where the caller finds a
/// triangle again.
pub(crate) trait LanePairs {
    /// What settles them.
    fn resolver(&self) -> Resolver<'_>;
    /// The ray of a lane.
    fn ray(&self, lane: usize) -> Ray;
    /// The triangle of a lane.
    fn triangle(&self, lane: usize) -> Triangle;
    /// The numbers of the ray and the place of the triangle of a lane.
    fn numbers(&self, lane: usize) -> (u32, u32);
    /// The triangle in a place.
    fn find(&self, place: u32) -> Triangle;

    /// t, if the pair of a lane is a hit.
    #[inline(always)]
    fn hit(&self, lane: usize) -> Option<f64> {
        self.resolver().hit(&self.ray(lane), &self.triangle(lane), self.numbers(lane))
    }

    /// Whether the pair of a lane is a hit.
    #[inline(always)]
    fn meets(&self, lane: usize) -> bool {
        self.resolver().meets(&self.ray(lane), &self.triangle(lane), self.numbers(lane))
    }

    /// t of the pair of a lane, which is known to be a hit.
    #[inline(always)]
    fn t(&self, lane: usize) -> f64 {
        self.resolver().t(&self.ray(lane), &self.triangle(lane), self.numbers(lane))
    }

    /// t of the lane's ray and the triangle in a place, which it is known to hit.
    #[inline(always)]
    fn t_in(&self, lane: usize, place: u32) -> f64 {
        let (ray, _) = self.numbers(lane);
        self.resolver().t(&self.ray(lane), &self.find(place), (ray, place))
    }

    /// Which comes first of two hits of a lane with equal rounded t: the triangle of the lane, or the one
    /// in a place.
    #[inline(always)]
    fn order(&self, lane: usize, place: u32) -> Ordering {
        let (number, here) = self.numbers(lane);
        let triangles = [&self.triangle(lane), &self.find(place)];
        self.resolver().order(&self.ray(lane), triangles, (number, here, place))
    }

    /// Whether the triangle of a lane and the one in a place touch where the lane's ray meets them, if it hits both.
    #[inline(always)]
    fn touch(&self, lane: usize, place: u32) -> bool {
        let pair = || (self.ray(lane), [self.triangle(lane), self.find(place)]);
        let (number, here) = self.numbers(lane);
        self.resolver().touch(pair, (number, here, place))
    }
}

/// The lanes of a packet of rays with one triangle.
pub(crate) struct RaysOnTriangle<'a, P, const N: usize> {
    pub(crate) resolver: Resolver<'a>,
    pub(crate) packet: &'a RayPacket<N>,
    /// The number of its first ray.
    pub(crate) first: u32,
    pub(crate) triangle: &'a Triangle,
    /// The triangle's place.
    pub(crate) place: u32,
    pub(crate) find: P,
}

impl<P: Fn(u32) -> Triangle, const N: usize> LanePairs for RaysOnTriangle<'_, P, N> {
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
    fn numbers(&self, lane: usize) -> (u32, u32) {
        (self.first + lane as u32, self.place)
    }
    #[inline(always)]
    fn find(&self, place: u32) -> Triangle {
        (self.find)(place)
    }
}

/// The lanes of a block of triangles with one ray.
pub(crate) struct RayOnBlock<'a, P, const N: usize> {
    pub(crate) resolver: Resolver<'a>,
    pub(crate) ray: &'a Ray,
    /// The ray's number.
    pub(crate) number: u32,
    pub(crate) block: &'a TriangleBlock<N>,
    /// The place of its first triangle.
    pub(crate) place: u32,
    pub(crate) find: P,
}

impl<P: Fn(u32) -> Triangle, const N: usize> LanePairs for RayOnBlock<'_, P, N> {
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
    fn numbers(&self, lane: usize) -> (u32, u32) {
        (self.number, self.place + lane as u32)
    }
    #[inline(always)]
    fn find(&self, place: u32) -> Triangle {
        (self.find)(place)
    }
}

/// The lanes of a row of triangles with one ray.
pub(crate) struct RayOnRow<'a, P> {
    pub(crate) resolver: Resolver<'a>,
    pub(crate) ray: &'a Ray,
    /// The place of its first triangle.
    pub(crate) first: u32,
    pub(crate) find: P,
}

impl<P: Fn(u32) -> Triangle> LanePairs for RayOnRow<'_, P> {
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
        (self.find)(self.first + lane as u32)
    }
    #[inline(always)]
    fn numbers(&self, lane: usize) -> (u32, u32) {
        (0, self.first + lane as u32)
    }
    #[inline(always)]
    fn find(&self, place: u32) -> Triangle {
        (self.find)(place)
    }
}
