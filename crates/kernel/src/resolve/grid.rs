//! The resolver of the grid: integers, which f32 hold exactly, in i64 and i128.

use core::cmp::Ordering;

use crate::fixed::{self, Crossing, Sides};
use crate::{Hit, Ray, Triangle};

/// See [`Resolver::hit`](super::Resolver::hit).
pub(super) fn hit(ray: &Ray, triangle: &Triangle) -> Option<f64> {
    let crossing = Crossing::of(&fixed::Ray::of_f32(ray), &fixed::Triangle::from_f32(triangle))?;
    Some(crossing.t.to_f64(0))
}

/// See [`Resolver::t`](super::Resolver::t).
pub(super) fn t(ray: &Ray, triangle: &Triangle) -> f64 {
    crossing(ray, triangle).t.to_f64(0)
}

/// See [`Resolver::order`](super::Resolver::order).
pub(super) fn order(ray: &Ray, a: &Triangle, b: &Triangle) -> Ordering {
    crossing(ray, a).t.cmp(&crossing(ray, b).t)
}

/// See [`Resolver::hit_attributes`](super::Resolver::hit_attributes).
pub(super) fn hit_attributes(ray: &Ray, triangle: &Triangle, index: u32) -> Hit {
    crossing(ray, triangle).to_hit(&fixed::Ray::of_f32(ray), index)
}

/// Where a ray crosses a triangle that it is known to cross.
fn crossing(ray: &Ray, triangle: &Triangle) -> Crossing {
    let ray = fixed::Ray::of_f32(ray);
    Sides::new(&fixed::Triangle::from_f32(triangle), ray.origin()).crossing(&ray)
}
