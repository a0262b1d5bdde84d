//! t of rays that share their origin: what depends on that and the triangle is computed once.

use core::cmp::Ordering;

use crate::document::SeenPlane;
use crate::fixed::{self, Crossing, Sides};
use crate::{Ray, Triangle};

/// A triangle as it is seen from the origin of rays that are known to hit it.
#[derive(Clone, Copy, Debug)]
pub enum SharedOrigin {
    /// For the document's operations.
    Document(SeenPlane),
    /// For integers.
    Grid(Sides),
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

    /// t of a ray, rounded to f64.
    #[inline(always)]
    pub fn t(&self, ray: &Ray) -> f64 {
        match self {
            Self::Document(plane) => plane.t(ray.dir),
            Self::Grid(sides) => grid_t(sides, ray),
        }
    }

    /// Which of two triangles whose rounded t are equal a ray hits first.
    #[cold]
    #[inline(never)]
    pub fn order(&self, other: &Self, ray: &Ray) -> Ordering {
        match (self, other) {
            (Self::Grid(a), Self::Grid(b)) => crossing(a, ray).t.cmp(&crossing(b, ray).t),
            _ => Ordering::Equal,
        }
    }
}

#[cold]
#[inline(never)]
fn grid_t(sides: &Sides, ray: &Ray) -> f64 {
    crossing(sides, ray).t.to_f64(0)
}

fn crossing(sides: &Sides, ray: &Ray) -> Crossing {
    sides.crossing(&fixed::Ray::of_f32(ray))
}
