//! Subnormal numbers are taken for zero while a peer runs that requires it.

/// Runs with subnormal numbers taken for zero, as Embree's manual recommends.
#[cfg(target_arch = "x86_64")]
pub fn with_flush_to_zero(run: impl FnOnce()) {
    const FLUSH: u32 = 0x8040;
    let mut before = 0_u32;
    // SAFETY: the control word is read, two bits of it are set, and it is put back.
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
