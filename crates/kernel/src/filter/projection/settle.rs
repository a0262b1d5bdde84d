//! Settles the undecided pairs of a bundle.

use core::cmp::Ordering;

use super::frame::Apex;
use crate::exact::{PairDecision, f32_bounds};
use crate::resolve::{Resolver, SharedOrigin};
use crate::{LeafSlot, Ray, RayId, Triangle};

/// Decides pairs of a bundle's rays and triangles with the mode's resolver.
///
/// ```
/// use intertri::internal::{Apex, Resolver, Settle};
/// use intertri::{LeafSlot, Ray, RayId, Triangle};
/// let triangles = [3.0, 5.0].map(|z| Triangle::new([0.0, 0.0, z], [1.0, 0.0, z], [0.0, 1.0, z]));
/// let rays = [Ray::new([0.25, 0.25, 0.0], [0.0, 0.0, 1.0])];
/// let (find, index) = (|LeafSlot(slot)| triangles[slot as usize], |LeafSlot(slot)| slot);
/// let (resolver, apex) = (Resolver::Document(0.0), Apex::Finite);
/// let settle = Settle { resolver, apex, rays: &rays, first: RayId(0), find, index, reversed: false };
/// assert_eq!([0, 1].map(|slot| settle.meeting(LeafSlot(slot), 0, 0b1)), [0b1, 0b1]);
/// ```
#[derive(Clone, Copy, Debug)]
pub struct Settle<'a, T, I> {
    /// The mode's resolver.
    pub resolver: Resolver<'a>,
    /// The apex of the bundle's rays.
    pub apex: Apex,
    /// The bundle's rays.
    pub rays: &'a [Ray],
    /// The id of the first ray.
    pub first: RayId,
    /// Returns the triangle in a slot.
    pub find: T,
    /// Returns the index of the triangle in a slot.
    pub index: I,
    /// Whether the rays in the bundle are traced backward, from their common end or from infinity. In
    /// that case, the test determines only whether the rays hit, and every t is 0.
    pub reversed: bool,
}

impl<'a, T: Fn(LeafSlot) -> Triangle, I: Fn(LeafSlot) -> u32> Settle<'a, T, I> {
    #[inline(always)]
    pub(super) fn id(&self, ray: usize) -> RayId {
        RayId(self.first.0 + ray as u32)
    }

    /// Returns which of the rays in up to sixteen lanes hit the triangle within their intervals. Lane i
    /// is the ray `first + i`.
    #[inline(always)]
    pub fn meeting(&self, slot: LeafSlot, first: usize, lanes: u32) -> u32 {
        self.resolver.meeting(
            lanes,
            #[inline(always)]
            |lane| (self.rays[first + lane], (self.find)(slot), (self.id(first + lane), slot)),
        )
    }

    /// Decides the pairs in up to sixteen lanes.
    #[inline(always)]
    pub(super) fn decide(
        &self,
        lanes: u32,
        pair: impl Fn(usize) -> (LeafSlot, usize),
    ) -> [PairDecision; 16] {
        self.resolver.decide_lanes(
            lanes,
            #[inline(always)]
            |lane| {
                let (slot, ray) = pair(lane);
                (self.rays[ray], (self.find)(slot), (self.id(ray), slot))
            },
        )
    }

    /// Settles a pair for which [`Settle::decide`] has this result. `other` is the triangle that is the
    /// ray's nearest hit so far, if any.
    pub(super) fn settle(
        &self,
        slot: LeafSlot,
        ray: usize,
        other: Option<LeafSlot>,
        decision: PairDecision,
    ) -> Settled {
        match decision {
            PairDecision::Miss => Settled::Behind,
            _ if self.reversed => Settled::Hit { t_lo: 0.0, t_hi: 0.0 },
            PairDecision::HitAt(t) => {
                let (t_lo, t_hi) = f32_bounds(t);
                Settled::Hit { t_lo, t_hi }
            }
            // Without an upper bound on t, no box behind the hit could be left out.
            PairDecision::Hit { t_hi: f32::INFINITY, .. } => {
                let ids = (self.id(ray), slot);
                let t = self.resolver.t(&self.rays[ray], &(self.find)(slot), ids);
                let (t_lo, t_hi) = f32_bounds(t);
                Settled::Hit { t_lo, t_hi }
            }
            PairDecision::Hit { t_lo, t_hi, edges } => match other {
                // If the ray meets both triangles at an edge or a corner that they share, the lower
                // index wins.
                Some(other) if edges != 0 && self.shares_feature(ray, (slot, edges), other) => {
                    let is_lower = (self.index)(slot) < (self.index)(other);
                    if is_lower { Settled::Tie } else { Settled::Behind }
                }
                _ => Settled::Hit { t_lo, t_hi },
            },
        }
    }

    /// Returns whether one triangle comes after another on a ray, by t or by index, if their
    /// coordinates alone tell. Returns false if they do not.
    #[inline(always)]
    pub(super) fn is_behind_by_coordinates(
        &self,
        ray: usize,
        one: LeafSlot,
        other: LeafSlot,
    ) -> bool {
        let pair = || (self.rays[ray], [(self.find)(one), (self.find)(other)]);
        let order = self.resolver.order_by_coordinates(pair, (self.id(ray), [one, other]));
        order.is_some_and(|order| {
            order.then_with(|| (self.index)(one).cmp(&(self.index)(other))).is_gt()
        })
    }

    /// Returns whether the corner or the edge on which a ray meets one triangle also belongs to another.
    #[inline(always)]
    fn shares_feature(&self, ray: usize, (one, edges): (LeafSlot, u8), other: LeafSlot) -> bool {
        let pair = || [(self.find)(one), (self.find)(other)];
        self.resolver.shares_feature(pair, edges, (self.id(ray), [one, other]))
    }

    /// Returns whether a triangle meets another one where a ray is known to hit that one, and has a
    /// higher index. It then does not matter whether the ray hits it.
    #[inline(always)]
    pub(super) fn is_later_at(&self, ray: usize, met: (LeafSlot, u8), slot: LeafSlot) -> bool {
        (self.index)(slot) > (self.index)(met.0) && self.shares_feature(ray, met, slot)
    }

    /// Returns which of two triangles a ray hits first, if that is known without an exact t.
    #[inline(always)]
    fn known_order(&self, ray: usize, one: LeafSlot, other: LeafSlot) -> Option<Ordering> {
        let pair = || (self.rays[ray], [(self.find)(one), (self.find)(other)]);
        self.resolver.known_order(pair, (self.id(ray), [one, other]))
    }

    /// Returns whether a ray hits one triangle before another; if both have the same t, the lower
    /// index comes first. The ray must be known to hit both. The coefficients of both triangles are
    /// cached for other rays.
    #[inline(always)]
    pub(super) fn is_before(
        &self,
        ray: usize,
        one: LeafSlot,
        other: LeafSlot,
        [kept_one, kept_other]: &mut [LastTriangle<'a>; 2],
    ) -> bool {
        if self.reversed {
            // For reversed rays, t is meaningless, and any-hit queries do not need an order.
            return false;
        }
        if let Apex::AtInfinity { .. } = self.apex {
            return self.is_before_alone(ray, one, other);
        }
        let (id, ray) = (self.id(ray), &self.rays[ray]);
        let (one_seen, other_seen) = (self.seen(one, kept_one), self.seen(other, kept_other));
        let order = one_seen.order(other_seen, ray, id);
        order.then((self.index)(one).cmp(&(self.index)(other))).is_lt()
    }

    /// Like [`Settle::is_before`], but for rays that do not share an origin.
    #[cold]
    #[inline(never)]
    fn is_before_alone(&self, ray: usize, one: LeafSlot, other: LeafSlot) -> bool {
        let order = self.known_order(ray, one, other).unwrap_or_else(|| {
            let pair = [&(self.find)(one), &(self.find)(other)];
            self.resolver.order(&self.rays[ray], pair, (self.id(ray), [one, other]))
        });
        order.then((self.index)(one).cmp(&(self.index)(other))).is_lt()
    }

    /// Returns the coefficients of a triangle relative to the origin of the rays.
    #[inline(always)]
    fn seen<'k>(&self, slot: LeafSlot, kept: &'k mut LastTriangle<'a>) -> &'k SharedOrigin<'a> {
        if kept.is_none_or(|(kept, _)| kept != slot) {
            *kept = None;
        }
        let (_, seen) = kept.get_or_insert_with(|| {
            // All rays in a bundle start at the same point, so the origin of the first ray will do.
            let (origin, ids) = (self.rays[0].origin, (self.first, slot));
            (slot, self.resolver.shared_origin(&(self.find)(slot), origin, ids))
        });
        seen
    }
}

/// What the resolver says about an undecided pair.
pub(super) enum Settled {
    /// A miss, or a hit that does not come before the nearest hit so far.
    Behind,
    /// A hit with the same t as the nearest hit so far and a lower index.
    Tie,
    /// A hit with t between these bounds, which may come before or after the nearest hit so far.
    Hit { t_lo: f32, t_hi: f32 },
}

/// The triangle whose coefficients were computed last.
pub(super) type LastTriangle<'a> = Option<(LeafSlot, SharedOrigin<'a>)>;
