//! The originals behind the f32 copies that a traversal tests.

use core::cmp::Ordering;
use core::fmt;
use core::ops::Range;

use crate::exact::{SeenPlane, Side};
use crate::{Hit, Hit32, LeafSlot, Ray64, RayId};

/// The f64 rays and triangles whose f32 copies the traversal tests. Pairs are identified by the traversal's
/// ids of the ray and the slot; answers are exact for the originals.
///
/// In units of the traversal, t is that of the copied ray: `t * 2^n`, with an n for each ray.
pub trait Originals: fmt::Debug + Sync {
    /// t in units of the traversal, correctly rounded, if the ray hits the triangle within its interval.
    fn hit(&self, ray: RayId, slot: LeafSlot) -> Option<f64>;

    /// t in units of the traversal, correctly rounded, for a triangle that the ray is known to hit.
    fn t(&self, ray: RayId, slot: LeafSlot) -> f64;

    /// Which of two triangles the ray hits first, both of which it is known to hit.
    fn order(&self, ray: RayId, one: LeafSlot, other: LeafSlot) -> Ordering;

    /// The ray.
    fn ray(&self, ray: RayId) -> &Ray64;

    /// The triangle's plane relative to the ray's origin.
    fn plane(&self, ray: RayId, slot: LeafSlot) -> SeenPlane<f64>;

    /// Whether two triangles certainly touch where the ray meets them, if it hits both.
    fn touch(&self, ray: RayId, one: LeafSlot, other: LeafSlot) -> bool;

    /// The side from which the ray crosses the triangle within its interval, if it does.
    fn crossing(&self, ray: RayId, slot: LeafSlot) -> Option<Side>;

    /// Whether the ray starts on the triangle.
    fn starts_on(&self, ray: RayId, slot: LeafSlot) -> bool;

    /// Whether the ray runs with the triangle's normal or against it; `None` if it runs parallel to the
    /// plane.
    fn facing(&self, ray: RayId, slot: LeafSlot) -> Option<Side>;

    /// The memory to prefetch while `count` rays are traced, starting with this one: rays that are copied
    /// later.
    fn later(&self, ray: RayId, count: usize) -> &[u8];

    /// Prefetches a pair.
    fn prefetch(&self, ray: RayId, slot: LeafSlot);

    /// Where rays meet triangles that they are known to hit, in units of the original rays.
    fn hits(&self, pairs: &[(RayId, LeafSlot)], hits: &mut [Hit]);

    /// [`Originals::hits`] for consecutive rays whose copies share their origin. A pair is an offset into `rays` and an
    /// index into `slots`; an index past the end stands for a miss.
    fn shared_origin_hits(
        &self,
        rays: Range<u32>,
        slots: &[LeafSlot],
        pairs: &[(u32, u32)],
        hits: &mut [Hit],
    );

    /// The hit of a pair in f32.
    fn hit32(&self, hit: &Hit, ray: RayId, slot: LeafSlot) -> Hit32;

    /// [`Originals::hits`] for one pair.
    fn hit_attributes(&self, ray: RayId, slot: LeafSlot) -> Hit {
        let mut hit = [Hit::MISS];
        self.hits(&[(ray, slot)], &mut hit);
        hit[0]
    }
}
