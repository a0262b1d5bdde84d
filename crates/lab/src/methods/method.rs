//! The laboratory's interface to every method, whether published or the kernel's.

use intertri::simd::Level;
use intertri::{Ray, Triangle};

use super::closest::Seconds;
use crate::layout::Layout;
use crate::test_batch::{Answer, ClosestHit, TestBatch};

/// One method in one precision.
#[derive(Clone, Copy, Debug)]
pub struct Method {
    /// Its name in tables and charts.
    pub name: &'static str,
    /// Its source.
    pub source: &'static str,
    /// The significant bits of its arithmetic: 24 or 53.
    pub bits: u32,
    pub(super) pairs: fn(Level, f64, &[Triangle], &[Ray], &mut [Answer]),
    pub(super) closest: fn(Level, &[TestBatch], Layout, &mut Vec<ClosestHit>) -> Option<Seconds>,
    pub(super) counts: fn(Level, &TestBatch) -> Vec<u32>,
}

impl Method {
    /// Tests ray `i` against triangle `i`, eight pairs at a time, in the lanes of a level.
    ///
    /// `threshold` is that of document A, finite and at least 0; methods without a threshold ignore it. The
    /// rays' intervals are ignored.
    ///
    /// # Panics
    /// Panics if the slices differ in length.
    pub fn pairs(
        &self,
        level: Level,
        threshold: f64,
        triangles: &[Triangle],
        rays: &[Ray],
        to: &mut [Answer],
    ) {
        assert!(triangles.len() == rays.len() && rays.len() == to.len(), "slices of equal length");
        (self.pairs)(level, threshold, triangles, rays, to);
    }

    /// Finds the closest hit of each ray in its batch, batch by batch. Returns the seconds that it took, not
    /// counting the values computed once per triangle. Returns `None`, and leaves `nearest` unchanged or
    /// empty, if the method does not support the layout: one lane for the kernel's modes, because that is the
    /// reference; rays without a common origin for the form that needs one; and 16 lanes for f64, or where
    /// they do not fit one register.
    ///
    /// `t_min` is 0 and `t_max` infinite for every ray.
    pub fn closest(
        &self,
        level: Level,
        batches: &[TestBatch],
        layout: Layout,
        nearest: &mut Vec<ClosestHit>,
    ) -> Option<Seconds> {
        (self.closest)(level, batches, layout, nearest)
    }

    /// How many triangles of its batch each ray hits; the rays' intervals are ignored.
    pub fn counts(&self, level: Level, batch: &TestBatch) -> Vec<u32> {
        (self.counts)(level, batch)
    }
}
