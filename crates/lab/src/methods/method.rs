//! The common interface to all methods, whether published or part of the kernel.

use intertri::simd::Level;
use intertri::{Ray, Triangle};

use super::closest::Seconds;
use crate::layout::Layout;
use crate::test_batch::{Answer, ClosestHit, TestBatch};

/// One method in one precision.
#[derive(Clone, Copy, Debug)]
pub struct Method {
    /// The name in tables and charts.
    pub name: &'static str,
    /// The source of the method.
    pub source: &'static str,
    /// The number of significant bits in the arithmetic: 24 or 53.
    pub bits: u32,
    pub(super) pairs: fn(Level, f64, &[Triangle], &[Ray], &mut [Answer]),
    pub(super) closest: fn(Level, &[TestBatch], Layout, &mut Vec<ClosestHit>) -> Option<Seconds>,
    pub(super) counts: fn(Level, &TestBatch) -> Vec<u32>,
}

impl Method {
    /// Tests ray `i` against triangle `i`, for every `i`, with a level's instructions.
    ///
    /// `threshold` is document A's threshold, which must be finite and at least 0. Methods without
    /// a threshold ignore it. The rays' intervals are ignored.
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
        assert!(
            triangles.len() == rays.len() && rays.len() == to.len(),
            "the slices must have equal lengths"
        );
        (self.pairs)(level, threshold, triangles, rays, to);
    }

    /// Finds the closest hit of each ray in its batch, batch by batch. Returns the time in seconds,
    /// without the time to compute values that depend only on the triangle.
    ///
    /// Returns `None`, and leaves `nearest` unchanged or empty, if the method does not support the
    /// layout. The kernel's modes do not support one lane, because the reference implementation
    /// already covers it, and their forms for one origin support only rays that share an origin.
    /// Published methods in f64 do not support 16 lanes, and no method does if 16 f32 values do not
    /// fit in one register.
    ///
    /// For every ray, `t_min` is 0 and `t_max` is infinite.
    pub fn closest(
        &self,
        level: Level,
        batches: &[TestBatch],
        layout: Layout,
        nearest: &mut Vec<ClosestHit>,
    ) -> Option<Seconds> {
        (self.closest)(level, batches, layout, nearest)
    }

    /// Counts how many triangles of its batch each ray hits, ignoring the rays' intervals.
    pub fn counts(&self, level: Level, batch: &TestBatch) -> Vec<u32> {
        (self.counts)(level, batch)
    }
}
