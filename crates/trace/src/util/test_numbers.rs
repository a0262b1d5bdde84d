//! Random numbers for tests, the same on every run.

/// Returns a generator of random numbers in `0..1`.
pub(crate) fn random() -> impl FnMut() -> f32 {
    let mut state = 1_u32;
    move || {
        state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        (state >> 8) as f32 / (1 << 24) as f32
    }
}
