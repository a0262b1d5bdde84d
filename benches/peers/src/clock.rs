//! The clock of the core: how fast it runs right now, by a chain of additions that take a cycle each.

use std::hint::black_box;
use std::time::Instant;

/// Additions in a sample, each of which waits for the one before.
const CHAIN: u32 = 100_000;
/// A repeat at a clock further than this from the middle one of its cell does not count.
const STEADY: f64 = 0.03;

/// The clock of all repeats of a cell.
#[derive(Default)]
pub struct Clock {
    seen: Vec<f64>,
}

impl Clock {
    /// Additions a nanosecond, now: the clock in GHz, of the better of two samples.
    pub fn now() -> f64 {
        sample().max(sample())
    }

    /// The fastest that is seen in a while.
    pub fn fastest() -> f64 {
        (0..400).map(|_| sample()).fold(0.0, f64::max)
    }

    /// Remembers the clock of a repeat.
    pub fn add(&mut self, clock: f64) {
        let at = self.seen.partition_point(|&seen| seen < clock);
        self.seen.insert(at, clock);
    }

    /// Whether a repeat at this clock counts: a dip does not, nor does a boost, but a clock that has
    /// become another for good is the clock.
    pub fn is_steady(&self, clock: f64) -> bool {
        self.seen
            .get(self.seen.len() / 2)
            .is_some_and(|middle| (clock / middle - 1.0).abs() <= STEADY)
    }
}

fn sample() -> f64 {
    let start = Instant::now();
    let mut x = black_box(1_u64);
    for _ in 0..CHAIN / 8 {
        // Opaque to the compiler, which would add them up at once.
        macro_rules! add {
            ($($again:tt)*) => { $( { let _ = $again; x = black_box_register(x); } )* };
        }
        add!(0 1 2 3 4 5 6 7);
    }
    black_box(x);
    f64::from(CHAIN) / start.elapsed().as_nanos() as f64
}

#[cfg(target_arch = "x86_64")]
#[inline(always)]
fn black_box_register(mut x: u64) -> u64 {
    // SAFETY: an addition of registers, nothing else.
    unsafe { std::arch::asm!("add {0}, {0}", inout(reg) x, options(pure, nomem, nostack)) };
    x
}

#[cfg(target_arch = "aarch64")]
#[inline(always)]
fn black_box_register(mut x: u64) -> u64 {
    // SAFETY: an addition of registers, nothing else.
    unsafe { std::arch::asm!("add {0}, {0}, {0}", inout(reg) x, options(pure, nomem, nostack)) };
    x
}
