//! The sRGB transfer function (IEC 61966-2-1) for eight bits per channel, with tables in both
//! directions.
//!
//! Code n begins at the light threshold where the curve reaches n - 1/2. Codes are looked up by the
//! exponent and the first seven fraction bits of the light:
//!
//! ```text
//!   f32   0 01111011 1011010.........    Thirteen octaves of 128 buckets, preceded by black.
//!           -------- -------             A bucket is narrower than any code, so it has at
//!           exponent bucket              most one threshold, and one comparison suffices.
//! ```

use std::sync::LazyLock;

use glam::Vec3;

/// Tables that convert light to codes and codes to light.
pub(crate) struct Srgb {
    /// The least light for each code, followed by infinity.
    thresholds: [f32; 257],
    /// The code at the beginning of each bucket.
    buckets: [u8; BUCKETS],
    /// The light of each code.
    light: [f32; 256],
}

/// The number of low bits of an f32 that do not affect its bucket.
const REST: u32 = 23 - 7;
/// The number of the first bucket, which begins at 2^-13, below the first threshold.
const FIRST: usize = (f32::MIN_POSITIVE.to_bits() as usize >> REST) + (126 - 13) * 128;
/// The number of buckets. The last bucket contains only 1.
const BUCKETS: usize = 13 * 128 + 1;

static SRGB: LazyLock<Srgb> = LazyLock::new(Srgb::new);

impl Srgb {
    /// Returns the tables.
    pub(crate) fn get() -> &'static Self {
        &SRGB
    }

    fn new() -> Self {
        let mut thresholds = [f32::INFINITY; 257];
        thresholds[0] = 0.0;
        for (code, threshold) in thresholds.iter_mut().enumerate().take(256).skip(1) {
            *threshold = rounded_up(linear((code as f64 - 0.5) / 255.0));
        }
        let mut buckets = [0; BUCKETS];
        let mut code = 0;
        for (i, bucket) in buckets.iter_mut().enumerate() {
            let begin = f32::from_bits(((FIRST + i) << REST) as u32);
            while begin >= thresholds[code + 1] {
                code += 1;
            }
            *bucket = code as u8;
        }
        let light = std::array::from_fn(|code| decode(code as u8));
        Self { thresholds, buckets, light }
    }

    /// Converts linear light to sRGB, clamped to `0..=1`; NaN is black.
    #[inline]
    pub(crate) fn encode(&self, Vec3 { x: r, y: g, z: b }: Vec3) -> [u8; 3] {
        [self.code(r), self.code(g), self.code(b)]
    }

    #[inline]
    fn code(&self, x: f32) -> u8 {
        // NaN is not greater than 0.
        let x = if x > 0.0 { x } else { 0.0 };
        let x = if x < 1.0 { x } else { 1.0 };
        let bucket = (x.to_bits() as usize >> REST).saturating_sub(FIRST);
        let code = self.buckets[bucket];
        code + u8::from(x >= self.thresholds[usize::from(code) + 1])
    }

    /// Converts one channel of sRGB to linear light.
    pub(crate) fn decode(&self, encoded: u8) -> f32 {
        self.light[usize::from(encoded)]
    }
}

/// Evaluates the curve from sRGB to linear light.
fn linear(encoded: f64) -> f64 {
    if encoded <= 0.040_45 { encoded / 12.92 } else { ((encoded + 0.055) / 1.055).powf(2.4) }
}

/// Evaluates [`linear`] in f32, for decoding textures.
fn decode(encoded: u8) -> f32 {
    let x = f32::from(encoded) / 255.0;
    if x <= 0.040_45 { x / 12.92 } else { ((x + 0.055) / 1.055).powf(2.4) }
}

/// Returns the smallest f32 that is not below `x`.
fn rounded_up(x: f64) -> f32 {
    let near = x as f32;
    if f64::from(near) < x { near.next_up() } else { near }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn code(x: f32) -> u8 {
        Srgb::get().encode(Vec3::splat(x))[1]
    }

    /// Evaluates the standard's curve from linear light to sRGB, in units of codes.
    fn exact(x: f32) -> f64 {
        let x = f64::from(x).clamp(0.0, 1.0);
        let encoded = if x <= 0.003_130_8 { 12.92 * x } else { 1.055 * x.powf(1.0 / 2.4) - 0.055 };
        encoded * 255.0
    }

    #[test]
    fn every_code_begins_where_the_exact_curve_rounds_to_it() {
        for n in 1..=255_u8 {
            let least = Srgb::get().thresholds[usize::from(n)];
            let half = f64::from(n) - 0.5;
            // The f64 error is about 1e-13 of a code, and no threshold is that close to the curve.
            assert!(exact(least) > half + 1e-12 && exact(least.next_down()) < half - 1e-12, "{n}");
            assert_eq!((code(least.next_down()), code(least)), (n - 1, n));
        }
    }

    #[test]
    fn between_the_thresholds_a_code_goes_on() {
        // Test the ends of all buckets, and many values in between.
        let mut bits = 0;
        while bits <= 1.0_f32.to_bits() {
            for x in [bits, bits.saturating_sub(1)].map(f32::from_bits) {
                assert_eq!(code(x), (exact(x) + 0.5) as u8, "{x:e}");
            }
            bits += 1 << 10;
        }
    }

    #[test]
    fn it_meets_the_standard() {
        let encode = |r, g, b| Srgb::get().encode(Vec3::new(r, g, b));
        assert_eq!(encode(0.0, 1.0, 7.0), [0, 255, 255]);
        assert_eq!(encode(-1.0, f32::INFINITY, -0.0), [0, 255, 0]);
        // Middle grey (18 %) has the code 118 (0.4613), and the linear part of the curve ends at
        // 0.04045.
        assert_eq!(encode(0.18, 0.002, f32::NAN), [118, 7, 0]);
        for encoded in 0..=255 {
            assert_eq!(code(Srgb::get().decode(encoded)), encoded);
        }
    }
}
