//! Which of two triangles rays meet first that share their origin: what depends on that and a triangle is
//! computed once.

use core::cmp::Ordering;

use super::originals::Originals;
use crate::document::SeenPlane;
use crate::exact;
use crate::fixed::{self, Sides};
use crate::{Ray, Triangle};

/// A triangle as it is seen from the origin of rays that are known to hit it.
#[derive(Clone, Copy, Debug)]
pub enum SharedOrigin<'a> {
    /// For the document's operations.
    Document(SeenPlane),
    /// For integers of a grid.
    Grid(Sides),
    /// For what is exact.
    Exact(exact::SeenPlane, Triangle),
    /// For originals, with its place.
    Originals(exact::SeenPlane<f64>, &'a dyn Originals, u32),
}

impl SharedOrigin<'_> {
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

    /// Which of two triangles, of one resolver, a ray hits first, by its number for originals.
    #[inline(always)]
    pub fn order(&self, other: &Self, ray: &Ray, number: u32) -> Ordering {
        match (self, other) {
            (Self::Document(a), Self::Document(b)) => a.t(ray.dir).total_cmp(&b.t(ray.dir)),
            (Self::Grid(a), Self::Grid(b)) => grid_order(a, b, ray),
            (Self::Exact(a, one), Self::Exact(b, other)) => {
                a.order(b, ray).unwrap_or_else(|| exact::order(ray, one, other))
            }
            (Self::Originals(a, originals, one), Self::Originals(b, _, other)) => a
                .order(b, originals.ray(number))
                .unwrap_or_else(|| originals.order(number, *one, *other)),
            _ => Ordering::Equal,
        }
    }
}

#[inline(never)]
fn grid_order(a: &Sides, b: &Sides, ray: &Ray) -> Ordering {
    let ray = fixed::Ray::of_f32(ray);
    a.crossing(&ray).t.cmp(&b.crossing(&ray).t)
}
