//! Which of two triangles rays meet first that share their origin: what depends on that and a triangle is
//! computed once.

use core::cmp::Ordering;

use crate::document::SeenPlane;
use crate::exact;
use crate::fixed::{self, Sides};
use crate::{Ray, Triangle};

/// A triangle as it is seen from the origin of rays that are known to hit it.
#[derive(Clone, Copy, Debug)]
pub enum SharedOrigin {
    /// For the document's operations.
    Document(SeenPlane),
    /// For integers of a grid.
    Grid(Sides),
    /// For what is exact.
    Exact(exact::SeenPlane),
}

impl SharedOrigin {
    #[inline(always)]
    pub(super) fn document(triangle: &Triangle, origin: [f32; 3]) -> Self {
        Self::Document(SeenPlane::new(triangle, origin))
    }

    #[cold]
    #[inline(never)]
    pub(super) fn grid(triangle: &Triangle, origin: [f32; 3]) -> Self {
        let ray = fixed::Ray::of_f32(&Ray::new(origin, [0.0; 3]));
        Self::Grid(Sides::new(&fixed::Triangle::from_f32(triangle), ray.origin()))
    }

    /// Which of two triangles, of one resolver, a ray hits first.
    #[inline(always)]
    pub fn order(&self, other: &Self, ray: &Ray) -> Ordering {
        match (self, other) {
            (Self::Document(a), Self::Document(b)) => a.t(ray.dir).total_cmp(&b.t(ray.dir)),
            (Self::Grid(a), Self::Grid(b)) => grid_order(a, b, ray),
            (Self::Exact(a), Self::Exact(b)) => a.order(b, ray),
            _ => Ordering::Equal,
        }
    }
}

#[inline(never)]
fn grid_order(a: &Sides, b: &Sides, ray: &Ray) -> Ordering {
    let ray = fixed::Ray::of_f32(ray);
    a.crossing(&ray).t.cmp(&b.crossing(&ray).t)
}
