//! The closed set of modes, and the one place that tells them apart.
//!
//! What is generic over modes is compiled again by every crate that calls it, for each level of
//! instructions. Queries come through here instead, where both tests are compiled once.

use alloc::vec::Vec;

use super::rows::Rows;
use super::slices::{All, Any, Closest, ClosestBatch, SharedOriginBatch, shares_origin};
use crate::filter::Filter;
use crate::intersect::Test;
use crate::lanes64::Lanes64;
use crate::resolve::Resolver;
use crate::simd::Level;
use crate::{Hit, Ray, Triangle};

/// The test of a mode: every mode is one of these, with a resolver of its own.
#[derive(Clone, Copy, Debug)]
pub enum Which<'a> {
    /// f32 lanes under a proven bound, and a resolver.
    Filter(Filter<'a>),
    /// f64 lanes.
    Lanes64(Lanes64),
}

impl<'a> From<Filter<'a>> for Which<'a> {
    #[inline]
    fn from(test: Filter<'a>) -> Self {
        Self::Filter(test)
    }
}

impl From<Lanes64> for Which<'_> {
    #[inline]
    fn from(test: Lanes64) -> Self {
        Self::Lanes64(test)
    }
}

impl Which<'_> {
    /// What settles the pairs that its test leaves undecided.
    #[inline]
    pub fn resolver(&self) -> Resolver<'_> {
        match self {
            Self::Filter(test) => test.resolver(),
            Self::Lanes64(test) => test.resolver(),
        }
    }

    /// The level of instructions.
    pub fn level(&self) -> Level {
        match self {
            Self::Filter(test) => test.level(),
            Self::Lanes64(test) => test.level(),
        }
    }

    /// See [`Mode::closest_batch`](super::Mode::closest_batch).
    pub(super) fn closest_batch(self, triangles: &[Triangle], rays: &[Ray], hits: &mut [Hit]) {
        assert_eq!(rays.len(), hits.len(), "one hit a ray");
        match self {
            Self::Filter(test) if shares_origin(rays) => {
                test.level().run(SharedOriginBatch { test, triangles, rays, hits });
            }
            Self::Filter(test) => test.level().run(ClosestBatch { test, triangles, rays, hits }),
            Self::Lanes64(test) => test.level().run(ClosestBatch { test, triangles, rays, hits }),
        }
    }

    /// See [`Mode::closest`](super::Mode::closest).
    pub(super) fn closest(self, rows: Rows<'_>, ray: &Ray) -> Option<Hit> {
        match self {
            Self::Filter(test) => test.level().run(Closest { test, rows, ray }),
            Self::Lanes64(test) => test.level().run(Closest { test, rows, ray }),
        }
    }

    /// See [`Mode::any`](super::Mode::any).
    pub(super) fn any(self, rows: Rows<'_>, ray: &Ray) -> bool {
        match self {
            Self::Filter(test) => test.level().run(Any { test, rows, ray }),
            Self::Lanes64(test) => test.level().run(Any { test, rows, ray }),
        }
    }

    /// See [`Mode::all`](super::Mode::all).
    pub(super) fn all(self, rows: Rows<'_>, ray: &Ray) -> Vec<Hit> {
        let (mut hits, resolver) = match self {
            Self::Filter(test) => (test.level().run(All { test, rows, ray }), test.resolver()),
            Self::Lanes64(test) => (test.level().run(All { test, rows, ray }), test.resolver()),
        };
        let found = |hit: &Hit| rows.triangle(hit.triangle);
        hits.sort_unstable_by(|a, b| {
            resolver.first((ray, 0), (a, &found(a), a.triangle), (b, &found(b), b.triangle))
        });
        hits
    }
}
