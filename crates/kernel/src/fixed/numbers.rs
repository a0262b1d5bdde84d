//! Powers of two and rounding without a math library, because the kernel supports `no_std`.

/// Adding this value to an f64 rounds the f64 to an integer, because f64 has no fractional digits
/// above 2^52.
const ABOVE: f64 = (3_i64 << 51) as f64;

/// Returns the nearest integer, ties to even, for a number in `-2^51..=2^51`. For other numbers,
/// the result is meaningless.
#[inline]
pub(super) fn round(x: f64) -> i64 {
    // The addition rounds to an integer, whose binary digits are the low bits of the sum.
    (x + ABOVE).to_bits().wrapping_sub(ABOVE.to_bits()) as i64
}

/// Returns `2^e`, which must be a normal number.
pub(super) fn pow2(e: i32) -> f64 {
    f64::from_bits(((e + 1023) as u64) << 52)
}

/// Returns the exponent e for which `2^e <= x < 2^(e+1)`. x must be normal and positive.
pub(super) fn exponent(x: f64) -> i32 {
    (x.to_bits() >> 52) as i32 - 1023
}

/// Converts f32 components that are exact integers to a grid vector. Rounding is cheaper than a
/// cast, which has to handle out-of-range values.
#[inline(always)]
pub(super) fn i32s([x, y, z]: [f32; 3]) -> [i32; 3] {
    [round(x.into()) as i32, round(y.into()) as i32, round(z.into()) as i32]
}

/// Converts a grid vector to f32 exactly.
#[inline(always)]
pub(super) fn f32s([x, y, z]: [i32; 3]) -> [f32; 3] {
    [x as f32, y as f32, z as f32]
}
