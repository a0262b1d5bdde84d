//! Computes t, orders and hits exactly: in f64 if an error bound allows it, and otherwise in
//! sufficiently wide integers.

use core::cmp::Ordering;

use crate::exact;
use crate::{Hit, Ray, Triangle, TriangleId};

/// See [`Resolver::t`](super::Resolver::t).
pub(super) fn t(ray: &Ray, triangle: &Triangle) -> f64 {
    exact::t(ray, triangle)
}

/// See [`Resolver::order`](super::Resolver::order).
pub(super) fn order(ray: &Ray, a: &Triangle, b: &Triangle) -> Ordering {
    exact::order(ray, a, b)
}

/// See [`Resolver::order_by_coordinates`](super::Resolver::order_by_coordinates).
pub(super) fn order_by_coordinates(ray: &Ray, a: &Triangle, b: &Triangle) -> Option<Ordering> {
    exact::order_by_coordinates(ray, a, b)
}

/// See [`Resolver::known_order`](super::Resolver::known_order).
#[cold]
#[inline(never)]
pub(super) fn known_order(ray: &Ray, a: &Triangle, b: &Triangle) -> Option<Ordering> {
    exact::known_order(ray, a, b)
}

/// See [`Resolver::hit_attributes`](super::Resolver::hit_attributes).
#[inline(never)]
pub(super) fn hit_attributes(ray: &Ray, triangle: &Triangle, TriangleId(index): TriangleId) -> Hit {
    let (t, u, v) = exact::attributes(ray, triangle);
    Hit { t, u, v, triangle: index, geometry: 0 }
}
