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

/// Receives the hits of a query and decides which ones to keep. Traversal uses it as a trait object,
/// so that it is compiled only once; the calls are rare.
pub(super) trait Collect {
    /// Returns whether each collected hit rules out all hits beyond it.
    fn shortens(&self) -> bool {
        false
    }

    /// Returns whether hits count regardless of geometry masks.
    fn all_geometries(&self) -> bool {
        false
    }

    /// Records a hit whose t is between the given bounds, which may be
    /// [`NO_BOUNDS`]. Returns false once no further hit can count.
    fn take(&mut self, hit: Candidate, bounds: [f64; 2]) -> bool;

    /// Returns the t beyond which hits are ignored. A hit at exactly this t may be ignored as well.
    fn far(&self) -> f64;
}

/// Collects the closest hit. Two hits are compared by bounds on t. If these overlap, the hits are
/// compared by the correctly rounded t and, if that is equal, by the exact t.
pub(super) struct Closest<'a> {
    pub(super) ray: &'a Ray64,
    /// The closest hit so far, and bounds on its t. Equal bounds are the correctly rounded t.
    best: Option<([f64; 2], Candidate)>,
    far: f64,
}

impl<'a> Closest<'a> {
    pub(super) fn of(ray: &'a Ray64) -> Self {
        Self { ray, best: None, far: ray.t_max }
    }

    /// Returns the closest hit.
    pub(super) fn best(&self) -> Option<Candidate> {
        self.best.map(|(_, best)| best)
    }

    /// Returns whether a hit whose bounds overlap those of the closest hit so far is closer. Also
    /// replaces both pairs of bounds by the correctly rounded t.
    #[inline(never)]
    fn is_beaten_by(&mut self, hit: &Candidate, bounds: &mut [f64; 2]) -> bool {
        let Some((best_bounds, best)) = &mut self.best else { return true };
        for (bounds, hit) in [(&mut *bounds, hit), (best_bounds, best)] {
            if bounds[0] != bounds[1] {
                *bounds = [exact::t(self.ray, &hit.triangle); 2];
            }
        }
        // Rounding is monotonic, so exact t values need comparing only if the rounded ones are
        // equal.
        let order = match bounds[0].total_cmp(&best_bounds[0]) {
            Ordering::Equal => exact::order(self.ray, &hit.triangle, &best.triangle),
            order => order,
        };
        order.then_with(|| hit.key().cmp(&best.key())).is_lt()
    }
}

/// What a collector receives for a hit whose t has no bounds.
pub(super) const NO_BOUNDS: [f64; 2] = [f64::NAN; 2];

/// The largest relative difference between useful bounds on t: 2^-24.
const CLOSE: f64 = 1.0 / (1 << 24) as f64;

/// Bounds below this (2^-1000) may have underflowed.
const LEAST: f64 = f64::from_bits((1023 - 1000) << 52);

impl Collect for Closest<'_> {
    fn shortens(&self) -> bool {
        true
    }

    fn take(&mut self, hit: Candidate, mut bounds: [f64; 2]) -> bool {
        // Bounds that are far apart would hardly shorten the ray. The comparisons are false for NaN.
        let [lo, hi] = bounds;
        if !(lo >= LEAST && hi >= lo && hi - lo <= CLOSE * lo) {
            bounds = [exact::t(self.ray, &hit.triangle); 2];
        }
        if let Some(([lo, hi], _)) = self.best {
            let is_closer =
                bounds[1] < lo || bounds[0] <= hi && self.is_beaten_by(&hit, &mut bounds);
            if !is_closer {
                return true;
            }
        }
        self.best = Some((bounds, hit));
        // Keep searching up to the next representable t, so that hits with the same rounded t are
        // still found.
        self.far = bounds[1].next_up().max(f64::MIN_POSITIVE).min(self.ray.t_max);
        true
    }

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
    fn take(&mut self, _: Candidate, _: [f64; 2]) -> bool {
        self.is_hit = true;
        false
    }

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
    fn take(&mut self, hit: Candidate, _: [f64; 2]) -> bool {
        self.hits.push(hit);
        true
    }

    fn far(&self) -> f64 {
        self.t_max
    }
}
