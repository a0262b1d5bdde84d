//! The transfer function of sRGB (IEC 61966-2-1), in eight bits a channel.

use glam::Vec3;

/// Linear light to sRGB, clamped to `0..=1`.
pub(crate) fn encode(linear: Vec3) -> [u8; 3] {
    linear.to_array().map(|x| {
        let x = x.clamp(0.0, 1.0);
        let encoded = if x <= 0.003_130_8 { 12.92 * x } else { 1.055 * x.powf(1.0 / 2.4) - 0.055 };
        (encoded * 255.0 + 0.5) as u8
    })
}

/// One channel of sRGB to linear light.
pub(crate) fn decode(encoded: u8) -> f32 {
    let x = f32::from(encoded) / 255.0;
    if x <= 0.040_45 { x / 12.92 } else { ((x + 0.055) / 1.055).powf(2.4) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn it_meets_the_standard() {
        assert_eq!(encode(Vec3::new(0.0, 1.0, 7.0)), [0, 255, 255]);
        // Middle gray of 18 % is 118 (0.4613), and the straight part ends at 0.04045.
        assert_eq!(encode(Vec3::new(0.18, 0.002, f32::NAN)), [118, 7, 0]);
        for encoded in 0..=255 {
            assert_eq!(encode(Vec3::splat(decode(encoded))), [encoded; 3]);
        }
    }
}
