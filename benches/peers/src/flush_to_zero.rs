//! Makes the CPU treat subnormal numbers as zero while a tracer that needs this setting runs.

/// Runs a function while the CPU treats subnormal numbers as zero, as Embree's manual recommends.
#[cfg(target_arch = "x86_64")]
pub fn with_flush_to_zero(run: impl FnOnce()) {
    const FLUSH: u32 = 0x8040;
    let mut before = 0_u32;
    // SAFETY: the code reads the control word, sets two of its bits, and restores it.
    unsafe {
        std::arch::asm!("stmxcsr [{}]", in(reg) &mut before, options(nostack));
        let flush = before | FLUSH;
        std::arch::asm!("ldmxcsr [{}]", in(reg) &flush, options(nostack, readonly));
        run();
        std::arch::asm!("ldmxcsr [{}]", in(reg) &before, options(nostack, readonly));
    }
}

#[cfg(not(target_arch = "x86_64"))]
pub fn with_flush_to_zero(run: impl FnOnce()) {
    run();
}
