//! Measures the core's current clock rate with chains of additions that take one cycle each.
//!
//! Several chains run side by side, so that the measured rate also drops if a second thread shares
//! the core.

use std::hint::black_box;
use std::time::Instant;

/// The number of additions in a chain, each of which depends on the previous addition.
const LENGTH: u32 = 100_000;
/// The number of chains in a sample.
const CHAINS: usize = 3;
/// Measurements are discarded if the clock rate differs from the usual one by more than this ratio.
const STEADY: f64 = 0.03;
/// Defines the usual clock rate: this many out of a thousand measurements are slower. The median
/// would mistake a dip for the usual rate if the dip lasted half of the time, and the fastest
/// measurement may be a boost.
const USUAL: usize = 900;

/// The clock rates measured while an engine traced the rays for one cell of the table.
#[derive(Default)]
pub struct Clock {
    seen: Vec<f64>,
}

impl Clock {
    /// Returns the clock rate in GHz, which is the number of additions per nanosecond in a chain.
    /// Takes two samples, and returns the higher one.
    pub fn now() -> f64 {
        sample().max(sample())
    }

    /// Returns the highest clock rate among many samples.
    pub fn fastest() -> f64 {
        (0..400).map(|_| sample()).fold(0.0, f64::max)
    }

    /// Records a clock rate.
    pub fn add(&mut self, clock: f64) {
        let at = self.seen.partition_point(|&seen| seen < clock);
        self.seen.insert(at, clock);
    }

    /// Returns whether a measurement at this clock rate counts. Measurements during a dip or a
    /// boost do not count, unless the rate has changed for good.
    pub fn is_steady(&self, clock: f64) -> bool {
        self.seen
            .get(self.seen.len() * USUAL / 1000)
            .is_some_and(|usual| (clock / usual - 1.0).abs() <= STEADY)
    }
}

fn sample() -> f64 {
    let start = Instant::now();
    let mut x = black_box([1_u64; CHAINS]);
    for _ in 0..LENGTH / 8 {
        // The assembly is opaque to the compiler, which could otherwise fold the additions into
        // one.
        macro_rules! add {
            ($($again:tt)*) => { $( { let _ = $again; x = x.map(add_to_itself); } )* };
        }
        add!(0 1 2 3 4 5 6 7);
    }
    black_box(x);
    f64::from(LENGTH) / start.elapsed().as_nanos() as f64
}

#[cfg(target_arch = "x86_64")]
#[inline(always)]
fn add_to_itself(mut x: u64) -> u64 {
    // SAFETY: the instruction only adds registers.
    unsafe { std::arch::asm!("add {0}, {0}", inout(reg) x, options(pure, nomem, nostack)) };
    x
}

#[cfg(target_arch = "aarch64")]
#[inline(always)]
fn add_to_itself(mut x: u64) -> u64 {
    // SAFETY: the instruction only adds registers.
    unsafe { std::arch::asm!("add {0}, {0}, {0}", inout(reg) x, options(pure, nomem, nostack)) };
    x
}
