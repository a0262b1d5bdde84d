//! Powers of two and rounding, without a library: the kernel has none where there is no `std`.

/// Above 2^52 f64 has no fractions, so adding this rounds as wanted.
const ABOVE: f64 = (3_i64 << 51) as f64;

/// The nearest integer, ties to even, of a number within `-2^51..=2^51`; of others, any.
#[inline]
pub(super) fn round(x: f64) -> i64 {
    // The addition rounds to a whole number, whose binary digits are then the low bits of the sum.
    (x + ABOVE).to_bits().wrapping_sub(ABOVE.to_bits()) as i64
}

/// `2^e`, for a normal result.
pub(super) fn pow2(e: i32) -> f64 {
    f64::from_bits(((e + 1023) as u64) << 52)
}

/// e of `2^e <= x < 2^(e+1)`, for a normal positive x.
pub(super) fn exponent(x: f64) -> i32 {
    (x.to_bits() >> 52) as i32 - 1023
}
