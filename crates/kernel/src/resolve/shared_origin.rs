//! Which of two triangles rays meet first that share their origin: what depends on that and a triangle is
//! computed once.

use core::cmp::Ordering;

use super::originals::Originals;
use crate::document::SeenPlane;
use crate::exact;
use crate::{LeafSlot, Ray, RayId, Triangle};

/// A triangle as it is seen from the origin of rays that are known to hit it.
#[derive(Clone, Copy, Debug)]
pub enum SharedOrigin<'a> {
    /// For the document's operations.
    Document(SeenPlane),
    /// For what is exact.
    Exact(exact::SeenPlane, Triangle),
    /// For originals, with its slot.
    Originals(exact::SeenPlane<f64>, &'a dyn Originals, LeafSlot),
}

impl SharedOrigin<'_> {
    #[inline(always)]
    pub(super) fn document(triangle: &Triangle, origin: [f32; 3]) -> Self {
        Self::Document(SeenPlane::new(triangle, origin))
    }

    /// Which of two triangles, of one resolver, a ray hits first, by its id for originals.
    #[inline(always)]
    pub fn order(&self, other: &Self, ray: &Ray, id: RayId) -> Ordering {
        match (self, other) {
            (Self::Document(a), Self::Document(b)) => a.t(ray.dir).total_cmp(&b.t(ray.dir)),
            (Self::Exact(a, one), Self::Exact(b, other)) => {
                // f64 under a bound first; integers where the two t are closer than that.
                a.order(b, ray).unwrap_or_else(|| exact::order(ray, one, other))
            }
            (Self::Originals(a, originals, one), Self::Originals(b, _, other)) => {
                a.order(b, originals.ray(id)).unwrap_or_else(|| originals.order(id, *one, *other))
            }
            _ => unreachable!("planes of two resolvers"),
        }
    }
}
