//! The clock of the core: how fast it runs right now, by chains of additions that take a cycle each.
//!
//! Several chains side by side, for a core that another thread shares is slower without another clock.

use std::hint::black_box;
use std::time::Instant;

/// Additions in a chain, each of which waits for the one before; and chains in a sample.
const LENGTH: u32 = 100_000;
const CHAINS: usize = 3;
/// Measurements at a clock further than this from the usual one do not count.
const STEADY: f64 = 0.03;
/// The usual clock: this many of a thousand measurements are slower. The median would take a dip for usual that lasts
/// half of the time; the fastest measurement may be a boost.
const USUAL: usize = 900;

/// The clock while an engine traced the rays of a cell.
#[derive(Default)]
pub struct Clock {
    seen: Vec<f64>,
}

impl Clock {
    /// Additions of a chain a nanosecond, now: the clock in GHz, of the better of two samples.
    pub fn now() -> f64 {
        sample().max(sample())
    }

    /// The fastest that is seen in a while.
    pub fn fastest() -> f64 {
        (0..400).map(|_| sample()).fold(0.0, f64::max)
    }

    /// Remembers a clock.
    pub fn add(&mut self, clock: f64) {
        let at = self.seen.partition_point(|&seen| seen < clock);
        self.seen.insert(at, clock);
    }

    /// Whether what was measured at this clock counts: in a dip it does not, nor in a boost, but a clock that
    /// has become another for good is the clock.
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
        // Opaque to the compiler, which would add them up at once.
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
    // SAFETY: an addition of registers, nothing else.
    unsafe { std::arch::asm!("add {0}, {0}", inout(reg) x, options(pure, nomem, nostack)) };
    x
}

#[cfg(target_arch = "aarch64")]
#[inline(always)]
fn add_to_itself(mut x: u64) -> u64 {
    // SAFETY: an addition of registers, nothing else.
    unsafe { std::arch::asm!("add {0}, {0}, {0}", inout(reg) x, options(pure, nomem, nostack)) };
    x
}
