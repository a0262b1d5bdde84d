//! The clock of the core: how fast it runs right now, by a chain of additions that take a cycle each.

use std::hint::black_box;
use std::time::Instant;

/// Additions in a sample, each of which waits for the one before.
const CHAIN: u32 = 100_000;
/// A core that runs at less than this share of its fastest is in a dip.
const STEADY: f64 = 0.97;

/// The fastest that was seen.
pub struct Clock {
    fastest: f64,
}

impl Clock {
    /// Runs until the clock no longer rises.
    pub fn new() -> Self {
        let fastest = (0..400).map(|_| sample()).fold(0.0, f64::max);
        Self { fastest }
    }

    /// Additions a nanosecond: the clock in GHz.
    pub fn fastest(&self) -> f64 {
        self.fastest
    }

    /// Whether the clock is up, of the better of two samples.
    pub fn steady(&mut self) -> bool {
        let now = sample().max(sample());
        self.fastest = self.fastest.max(now);
        now >= STEADY * self.fastest
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
