//! Access to the f64 originals whose f32 copies a traversal tests.

use core::cmp::Ordering;
use core::fmt;
use core::ops::Range;

use crate::exact::{PairDecision, Rule, SeenPlane, Side};
use crate::{Hit, Hit32, LeafSlot, Ray64, RayId};

/// The f64 rays and triangles whose f32 copies the traversal tests. A pair is identified by the
/// traversal's ray id and slot. Results are exact for the originals.
///
/// In units of the traversal, t is measured along the copied ray: it is the original t times `2^n`,
/// where n depends on the ray.
pub trait Originals: fmt::Debug + Sync {
    /// Decides a pair. The bounds on t are in units of the traversal.
    fn decide(&self, ray: RayId, slot: LeafSlot) -> PairDecision;

    /// Returns the rule of the query, which determines which triangles own an edge.
    fn rule(&self) -> Rule;

    /// Like [`Originals::decide`], but under any rule, and for up to eight pairs. A few of them may stay
    /// undecided. The other elements are meaningless.
    fn decide_eight(&self, rule: Rule, pairs: &[(RayId, LeafSlot)]) -> [Option<PairDecision>; 8];

    /// Returns the t of a hit in units of the traversal, correctly rounded. The ray must be known
    /// to hit the triangle.
    fn t(&self, ray: RayId, slot: LeafSlot) -> f64;

    /// Returns which of two triangles the ray hits first. The ray must be known to hit both.
    fn order(&self, ray: RayId, one: LeafSlot, other: LeafSlot) -> Ordering;

    /// Returns which of two triangles the ray hits first, if their coordinates alone tell. If the ray
    /// misses one of them, the result is meaningless.
    fn order_by_coordinates(&self, ray: RayId, one: LeafSlot, other: LeafSlot) -> Option<Ordering>;

    /// Returns the original ray.
    fn ray(&self, ray: RayId) -> &Ray64;

    /// Returns the triangle's plane relative to the ray's origin.
    fn plane(&self, ray: RayId, slot: LeafSlot) -> SeenPlane<f64>;

    /// Returns which of two triangles the ray hits first, if that is known without an exact t. If
    /// the ray misses one of the triangles, the result is meaningless.
    fn known_order(&self, ray: RayId, one: LeafSlot, other: LeafSlot) -> Option<Ordering>;

    /// Returns whether the corner or the edge on which the ray meets the first triangle, given by its
    /// edges, also belongs to the other.
    fn shares_feature(&self, ray: RayId, one: (LeafSlot, u8), other: LeafSlot) -> bool;

    /// Returns the side from which the ray crosses the triangle within its interval, if it does.
    fn crossing(&self, ray: RayId, slot: LeafSlot) -> Option<Side>;

    /// Returns whether the ray starts on the triangle.
    fn starts_on(&self, ray: RayId, slot: LeafSlot) -> bool;

    /// Returns whether the ray crosses the triangle's plane in the direction of the normal or
    /// against it, or `None` if the ray is parallel to the plane.
    fn facing(&self, ray: RayId, slot: LeafSlot) -> Option<Side>;

    /// Returns the memory to prefetch while `count` rays, starting with `ray`, are traced: the
    /// original rays that will be copied later.
    fn later(&self, ray: RayId, count: usize) -> &[u8];

    /// Prefetches the originals of a pair.
    fn prefetch(&self, ray: RayId, slot: LeafSlot);

    /// Computes where rays meet triangles that they are known to hit, in units of the original
    /// rays.
    fn hits(&self, pairs: &[(RayId, LeafSlot)], hits: &mut [Hit]);

    /// Like [`Originals::hits`], but for consecutive rays whose copies share an origin. A pair is
    /// an offset into `rays` and an index into `slots`; an index past the end stands for a miss.
    fn shared_origin_hits(
        &self,
        rays: Range<u32>,
        slots: &[LeafSlot],
        pairs: &[(u32, u32)],
        hits: &mut [Hit],
    );

    /// Converts the hit of a pair to f32.
    fn hit32(&self, hit: &Hit, ray: RayId, slot: LeafSlot) -> Hit32;

    /// Like [`Originals::hits`], but for one pair.
    fn hit_attributes(&self, ray: RayId, slot: LeafSlot) -> Hit {
        let mut hit = [Hit::MISS];
        self.hits(&[(ray, slot)], &mut hit);
        hit[0]
    }
}
