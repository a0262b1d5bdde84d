//! Collectors for the hits that traversal finds: the closest hit, any hit, or all hits.

use std::cmp::Ordering;

use intertri::internal::exact;
use intertri::{Ray64, Triangle64};

/// A hit: the instance, the triangle's position in its mesh, and the triangle in world space.
#[derive(Clone, Copy, Debug)]
pub(super) struct Candidate {
    pub(super) instance: u32,
    pub(super) position: u32,
    pub(super) triangle: Triangle64,
}

impl Candidate {
    /// Returns the sort key for hits with equal t: the instance and the triangle's position.
    pub(super) fn key(&self) -> (u32, u32) {
        (self.instance, self.position)
    }
}

/// Receives the hits of a query and decides which ones to keep.
pub(super) trait Collect {
    /// Whether each collected hit rules out all hits beyond it.
    const SHORTENS: bool;

    /// Whether hits count regardless of geometry masks.
    const ALL_GEOMETRIES: bool = false;

    /// Records a hit. Returns false once no further hit can count.
    fn take(&mut self, hit: Candidate) -> bool;

    /// Returns the t beyond which hits are ignored. A hit at exactly this t may be ignored as well.
    fn far(&self) -> f64;
}

/// Collects the closest hit.
pub(super) struct Closest<'a> {
    pub(super) ray: &'a Ray64,
    /// The closest hit so far and its correctly rounded t.
    pub(super) best: Option<(f64, Candidate)>,
    far: f64,
}

impl<'a> Closest<'a> {
    pub(super) fn of(ray: &'a Ray64) -> Self {
        Self { ray, best: None, far: ray.t_max }
    }
}

impl Collect for Closest<'_> {
    const SHORTENS: bool = true;

    #[inline(never)]
    fn take(&mut self, hit: Candidate) -> bool {
        let t = exact::t(self.ray, &hit.triangle);
        // Rounding is monotonic, so exact t values need comparing only if the rounded ones are
        // equal.
        let is_closer = self.best.as_ref().is_none_or(|(least, best)| {
            let order = match t.total_cmp(least) {
                Ordering::Equal => exact::order(self.ray, &hit.triangle, &best.triangle),
                order => order,
            };
            order.then_with(|| hit.key().cmp(&best.key())).is_lt()
        });
        if is_closer {
            self.best = Some((t, hit));
            // Keep searching up to the next representable t, so that hits with the same rounded t
            // are still found.
            self.far = t.next_up().max(f64::MIN_POSITIVE).min(self.ray.t_max);
        }
        true
    }

    #[inline(always)]
    fn far(&self) -> f64 {
        self.far
    }
}

/// Stops at the first hit.
pub(super) struct Any {
    pub(super) t_max: f64,
    pub(super) is_hit: bool,
}

impl Collect for Any {
    const SHORTENS: bool = false;

    fn take(&mut self, _: Candidate) -> bool {
        self.is_hit = true;
        false
    }

    #[inline(always)]
    fn far(&self) -> f64 {
        self.t_max
    }
}

/// Collects all hits.
pub(super) struct All {
    pub(super) t_max: f64,
    pub(super) hits: Vec<Candidate>,
}

impl Collect for All {
    const SHORTENS: bool = false;

    fn take(&mut self, hit: Candidate) -> bool {
        self.hits.push(hit);
        true
    }

    #[inline(always)]
    fn far(&self) -> f64 {
        self.t_max
    }
}
