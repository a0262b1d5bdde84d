//! Settles the undecided pairs of a bundle.

use core::cmp::Ordering;

use crate::exact::PairDecision;
use crate::resolve::{Resolver, SharedOrigin};
use crate::{LeafSlot, Ray, RayId, Triangle};

/// Decides pairs of a bundle's rays and triangles with the mode's resolver.
///
/// ```
/// use intertri::internal::{Resolver, Settle};
/// use intertri::{LeafSlot, Ray, RayId, Triangle};
/// let triangles = [3.0, 5.0].map(|z| Triangle::new([0.0, 0.0, z], [1.0, 0.0, z], [0.0, 1.0, z]));
/// let rays = [Ray::new([0.25, 0.25, 0.0], [0.0, 0.0, 1.0])];
/// let (find, index) = (|LeafSlot(slot)| triangles[slot as usize], |LeafSlot(slot)| slot);
/// let settle =
///     Settle { resolver: Resolver::Document(0.0), rays: &rays, first: RayId(0), find, index, reversed: false };
/// assert!(settle.meets(LeafSlot(0), 0) && settle.meets(LeafSlot(1), 0));
/// ```
#[derive(Clone, Copy, Debug)]
pub struct Settle<'a, T, I> {
    /// The mode's resolver.
    pub resolver: Resolver<'a>,
    /// The bundle's rays.
    pub rays: &'a [Ray],
    /// The id of the first ray.
    pub first: RayId,
    /// Returns the triangle in a slot.
    pub find: T,
    /// Returns the index of the triangle in a slot.
    pub index: I,
    /// Whether the rays in the bundle are reversed, so that they start at their common end. In that
    /// case, the test determines only whether the rays hit, and every t is 0.
    pub reversed: bool,
}

impl<'a, T: Fn(LeafSlot) -> Triangle, I: Fn(LeafSlot) -> u32> Settle<'a, T, I> {
    #[inline(always)]
    fn id(&self, ray: usize) -> RayId {
        RayId(self.first.0 + ray as u32)
    }

    /// Decides a pair in f64, if that suffices.
    #[inline(always)]
    pub(super) fn decide(&self, slot: LeafSlot, ray: usize) -> PairDecision {
        let ids = (self.id(ray), slot);
        match self.resolver.decide(&self.rays[ray], &(self.find)(slot), ids) {
            PairDecision::Hit { .. } if self.reversed => PairDecision::Hit { t_lo: 0.0, t_hi: 0.0 },
            decision => decision,
        }
    }

    /// Returns whether a ray hits the triangle within its interval.
    #[inline(always)]
    pub fn meets(&self, slot: LeafSlot, ray: usize) -> bool {
        self.resolver.meets(&self.rays[ray], &(self.find)(slot), (self.id(ray), slot))
    }

    /// Returns whether a ray hits the triangle, for a pair that [`Settle::decide`] has left
    /// undecided.
    #[inline(always)]
    fn meets_undecided(&self, slot: LeafSlot, ray: usize) -> bool {
        let ids = (self.id(ray), slot);
        self.resolver.meets_undecided(&self.rays[ray], &(self.find)(slot), ids)
    }

    /// Settles a pair that [`Settle::decide`] has left undecided. `other` is the triangle that the
    /// ray is known to hit, if any.
    #[inline(always)]
    pub(super) fn hit_or_tie(
        &self,
        slot: LeafSlot,
        ray: usize,
        other: Option<LeafSlot>,
    ) -> HitOrTie {
        // If the triangle is behind the other one, it does not matter whether it is hit. If both
        // have the same t, for example at a shared edge, the lower index wins.
        if let Some(other) = other
            && let Some(order) = self.known_order(ray, slot, other)
            && order.is_ge()
        {
            let is_lower = (self.index)(slot) < (self.index)(other);
            let wins = order.is_eq() && is_lower && self.meets_undecided(slot, ray);
            return if wins { HitOrTie::Tie } else { HitOrTie::Behind };
        }
        self.hit_undecided(slot, ray).map_or(HitOrTie::Behind, HitOrTie::Hit)
    }

    /// Returns the t of a ray if it hits the triangle, for a pair that [`Settle::decide`] has left
    /// undecided.
    #[inline(always)]
    fn hit_undecided(&self, slot: LeafSlot, ray: usize) -> Option<f64> {
        if self.reversed {
            return self.meets_undecided(slot, ray).then_some(0.0);
        }
        let ids = (self.id(ray), slot);
        self.resolver.hit_undecided(&self.rays[ray], &(self.find)(slot), ids)
    }

    /// Returns which of two triangles a ray hits first, if that is known without computing t.
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
        let (id, ray) = (self.id(ray), &self.rays[ray]);
        let (one_seen, other_seen) = (self.seen(one, kept_one), self.seen(other, kept_other));
        let order = one_seen.order(other_seen, ray, id);
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

/// What is known of a pair that f64 could not decide.
pub(super) enum HitOrTie {
    /// A miss, or a hit that does not come before the other one.
    Behind,
    /// A hit with the same t as the other one and a lower index.
    Tie,
    /// A hit with this t, which may come before or after the other one.
    Hit(f64),
}

/// The triangle whose coefficients were computed last.
pub(super) type LastTriangle<'a> = Option<(LeafSlot, SharedOrigin<'a>)>;
