//! Who knows the originals of the copies that a walk goes over.

use core::cmp::Ordering;
use core::fmt;
use core::ops::Range;

use crate::exact::{SeenPlane, Side};
use crate::{Hit, Ray64};

/// The rays and triangles that a walk has copies of in f32: asked about pairs by the walk's numbers, of the ray and of
/// the triangle's place, and exact about what was given.
///
/// In units of the walk t is what it is of the copy of the ray, `t * 2^n` with an n of each ray.
pub trait Originals: fmt::Debug + Sync {
    /// t in units of the walk, rounded once, if the ray hits the triangle within its interval.
    fn hit(&self, ray: u32, place: u32) -> Option<f64>;

    /// t in units of the walk, rounded once, of a triangle that the ray is known to hit.
    fn t(&self, ray: u32, place: u32) -> f64;

    /// Which of two triangles the ray hits first, both of which it is known to hit.
    fn order(&self, ray: u32, one: u32, other: u32) -> Ordering;

    /// The ray.
    fn ray(&self, ray: u32) -> &Ray64;

    /// The triangle's plane as it is seen from where the ray starts.
    fn plane(&self, ray: u32, place: u32) -> SeenPlane<f64>;

    /// Whether two triangles surely touch where the ray meets them, if it hits both.
    fn touch(&self, ray: u32, one: u32, other: u32) -> bool;

    /// The side from which the ray crosses the triangle within its interval, if it does.
    fn crossing(&self, ray: u32, place: u32) -> Option<Side>;

    /// Whether the ray starts on the triangle.
    fn starts_on(&self, ray: u32, place: u32) -> bool;

    /// Whether the ray runs with the triangle's normal or against it; `None` where it runs along the plane.
    fn facing(&self, ray: u32, place: u32) -> Option<Side>;

    /// What to prefetch while this ray and those after it are traced, so many in all: rays that are copied later.
    fn later(&self, ray: u32, count: usize) -> &[u8];

    /// Prefetches a pair.
    fn prefetch(&self, ray: u32, place: u32);

    /// Where rays meet triangles that they are known to hit, in units of the rays as given: the first of each pair is
    /// the ray.
    fn hits(&self, pairs: &[(u32, u32)], hits: &mut [Hit]);

    /// The same of rays in a row that start at one origin: of pairs of one of them and which of `places` it is known to
    /// hit; beyond all of them, where it hits none.
    fn shared_origin_hits(
        &self,
        rays: Range<u32>,
        places: &[u32],
        pairs: &[(u32, u32)],
        hits: &mut [Hit],
    );

    /// The same of one pair.
    fn hit_attributes(&self, ray: u32, place: u32) -> Hit {
        let mut hit = [Hit::MISS];
        self.hits(&[(ray, place)], &mut hit);
        hit[0]
    }
}
