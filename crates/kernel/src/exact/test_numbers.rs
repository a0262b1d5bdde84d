//! Generates random numbers for tests. The sequence is the same in every run.

/// Returns a generator of random numbers between -1/2 and 1/2.
pub(crate) fn random() -> impl FnMut() -> f64 {
    let mut state = 1_u64;
    move || {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
        (state >> 11) as f64 / (1_u64 << 53) as f64 - 0.5
    }
}
