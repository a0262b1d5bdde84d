//! Hashes answers.

use intertri::Hit;
use intertri_trace::{ClosestPoint, Containment};

/// An FNV-1a hash over 64-bit words, and a number of hits, crossings, or points inside.
pub(crate) struct Digest {
    pub(crate) hash: u64,
    pub(crate) hits: u64,
}

impl Digest {
    pub(crate) fn new() -> Self {
        Self { hash: 0xcbf2_9ce4_8422_2325, hits: 0 }
    }

    pub(crate) fn word(&mut self, word: u64) {
        self.hash = (self.hash ^ word).wrapping_mul(0x0000_0100_0000_01b3);
    }

    /// Adds a number. All NaNs count as equal.
    pub(crate) fn number(&mut self, x: f64) {
        self.word(if x.is_nan() { f64::NAN.to_bits() } else { x.to_bits() });
    }

    pub(crate) fn hit(&mut self, hit: &Hit) {
        self.hits += u64::from(hit.is_hit());
        self.word(hit.triangle.into());
        for x in [hit.t, hit.u, hit.v] {
            self.number(x);
        }
    }

    /// Adds a Boolean; true counts as a hit.
    pub(crate) fn truth(&mut self, truth: bool) {
        self.hits += u64::from(truth);
        self.word(truth.into());
    }

    /// Adds a closest point.
    pub(crate) fn closest_point(&mut self, found: &ClosestPoint) {
        self.hits += u64::from(found.some().is_some());
        self.word(found.triangle.into());
        for x in [found.distance, found.u, found.v].into_iter().chain(found.point) {
            self.number(x);
        }
    }

    /// Adds a containment; outside counts as a miss.
    pub(crate) fn containment(&mut self, containment: Containment) {
        self.hits += u64::from(containment != Containment::Outside);
        self.word(match containment {
            Containment::Outside => 0,
            Containment::Inside(times) => times as u64,
            Containment::Surface => u64::MAX / 2,
        });
    }
}
