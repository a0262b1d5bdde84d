//! Determines which of two triangles a ray meets first, for rays with a common origin. The values
//! that depend only on the origin and a triangle are computed once.

use core::cmp::Ordering;

use super::originals::Originals;
use crate::document::SeenPlane;
use crate::exact;
use crate::{LeafSlot, Ray, RayId, Triangle};

/// A triangle relative to the origin of rays that are known to hit it.
#[derive(Clone, Copy, Debug)]
pub enum SharedOrigin<'a> {
    /// The triangle's plane, for the document's operations.
    Document(SeenPlane),
    /// The triangle and its plane, for exact results.
    Exact(exact::SeenPlane, Triangle),
    /// The original triangle's plane, the originals, and the triangle's slot, for exact results on
    /// the originals.
    Originals(exact::SeenPlane<f64>, &'a dyn Originals, LeafSlot),
}

impl SharedOrigin<'_> {
    #[inline(always)]
    pub(super) fn document(triangle: &Triangle, origin: [f32; 3]) -> Self {
        Self::Document(SeenPlane::new(triangle, origin))
    }

    /// Returns which of two triangles a ray hits first. Both triangles must belong to the same
    /// resolver; `id` is used only for originals.
    #[inline(always)]
    pub fn order(&self, other: &Self, ray: &Ray, id: RayId) -> Ordering {
        match (self, other) {
            (Self::Document(a), Self::Document(b)) => a.t(ray.dir).total_cmp(&b.t(ray.dir)),
            (Self::Exact(a, one), Self::Exact(b, other)) => {
                // Try f64 with an error bound first. Use integers if the bound does not separate
                // the two values of t.
                a.order(b, ray).unwrap_or_else(|| exact::order(ray, one, other))
            }
            (Self::Originals(a, originals, one), Self::Originals(b, _, other)) => {
                a.order(b, originals.ray(id)).unwrap_or_else(|| originals.order(id, *one, *other))
            }
            _ => unreachable!("both planes belong to the same resolver"),
        }
    }
}
