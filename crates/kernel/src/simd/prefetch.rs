//! Prefetches memory before it is used.

/// Prefetches values that will be used soon, if the CPU has an instruction for it.
///
/// ```
/// let far_away = vec![1.0_f32; 1000];
/// intertri::simd::prefetch(&far_away[500..516]);
/// ```
#[inline(always)]
pub fn prefetch<T>(things: &[T]) {
    ask::<FIRST_CACHE, T>(things);
}

/// Prefetches values into the L2 cache for later use, so that they do not evict values that are
/// used in the meantime.
///
/// ```
/// let far_away = vec![1.0_f32; 1000];
/// intertri::simd::prefetch_early(&far_away[500..516]);
/// ```
#[inline(always)]
pub fn prefetch_early<T>(things: &[T]) {
    ask::<SECOND_CACHE, T>(things);
}

/// The x86 hint `_MM_HINT_T0`: prefetch into the L1 cache.
const FIRST_CACHE: i32 = 3;
/// The x86 hint `_MM_HINT_T1`: prefetch into the L2 cache.
const SECOND_CACHE: i32 = 2;

#[allow(unsafe_code)]
#[inline(always)]
fn ask<const CACHE: i32, T>(things: &[T]) {
    #[cfg(target_arch = "x86_64")]
    for line in 0..size_of_val(things).div_ceil(64) {
        let address = things.as_ptr().cast::<i8>().wrapping_add(64 * line);
        // SAFETY: this is only a hint, valid for any address, and every x86-64 CPU supports it.
        unsafe { core::arch::x86_64::_mm_prefetch::<CACHE>(address) };
    }
    #[cfg(not(target_arch = "x86_64"))]
    let _ = things;
}
