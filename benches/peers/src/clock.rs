//! Measures the current clock rate of the core, by chains of additions that take one cycle each.
//!
//! Several chains run side by side, because a core that is shared with another thread is slower at the same
//! clock rate.

use std::hint::black_box;
use std::time::Instant;

/// The length of a chain, in which each addition waits for the one before, and the number of chains in a
/// sample.
const LENGTH: u32 = 100_000;
const CHAINS: usize = 3;
/// Measurements at a clock rate further than this from the usual one are discarded.
const STEADY: f64 = 0.03;
/// The usual clock rate: this many of a thousand measurements are slower. The median would mistake a dip for
/// usual if it lasted half of the time; the fastest measurement may be a boost.
const USUAL: usize = 900;

/// The clock rates while an engine traced the rays of a cell.
#[derive(Default)]
pub struct Clock {
    seen: Vec<f64>,
}

impl Clock {
    /// Additions per nanosecond in a chain, that is, the clock rate in GHz: the better of two samples.
    pub fn now() -> f64 {
        sample().max(sample())
    }

    /// The fastest clock rate seen in a while.
    pub fn fastest() -> f64 {
        (0..400).map(|_| sample()).fold(0.0, f64::max)
    }

    /// Records a clock rate.
    pub fn add(&mut self, clock: f64) {
        let at = self.seen.partition_point(|&seen| seen < clock);
        self.seen.insert(at, clock);
    }

    /// Whether a measurement at this clock rate counts. It does not in a dip or a boost; if the rate has
    /// changed for good, it does.
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
        // Opaque to the compiler, which would otherwise fold the additions.
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
    // SAFETY: only adds registers.
    unsafe { std::arch::asm!("add {0}, {0}", inout(reg) x, options(pure, nomem, nostack)) };
    x
}

#[cfg(target_arch = "aarch64")]
#[inline(always)]
fn add_to_itself(mut x: u64) -> u64 {
    // SAFETY: only adds registers.
    unsafe { std::arch::asm!("add {0}, {0}, {0}", inout(reg) x, options(pure, nomem, nostack)) };
    x
}
