//! Reductions across lanes, and iteration over the lanes of a mask.

pub(crate) use intertri::internal::lanes_of;
use intertri::simd::{Lanes, Simd};

/// Splits sixteen lanes into four groups of four.
#[inline(always)]
pub(crate) fn fours<S: Simd>(lanes: S::F32x16) -> [S::F32x4; 4] {
    let mut n = [0.0; 16];
    lanes.store(&mut n);
    [Lanes::load(&n), Lanes::load(&n[4..]), Lanes::load(&n[8..]), Lanes::load(&n[12..])]
}

/// Returns the smallest of sixteen lanes.
#[inline(always)]
pub(crate) fn smallest<S: Simd>(lanes: S::F32x16) -> f32 {
    let [a, b, c, d] = fours::<S>(lanes);
    let mut numbers = [0.0; 4];
    a.min(b).min(c.min(d)).store(&mut numbers);
    let less = |a: f32, b: f32| if a < b { a } else { b };
    less(less(numbers[0], numbers[1]), less(numbers[2], numbers[3]))
}

/// Returns the sum of up to sixteen lanes.
#[inline(always)]
pub(crate) fn total<F: Lanes<Scalar = f32>>(lanes: F) -> f32 {
    let mut n = [0.0_f32; 16];
    lanes.store(&mut n);
    let mut four = [0.0; 4];
    for i in 0..4 {
        // Add in a fixed order, so that every level computes the same sum.
        four[i] = (n[i] + n[4 + i]) + (n[8 + i] + n[12 + i]);
    }
    (four[0] + four[1]) + (four[2] + four[3])
}

/// Returns the smallest of eight lanes.
#[inline(always)]
pub(crate) fn smallest_of_eight<S: Simd>(lanes: S::F32x8) -> f32 {
    // Combine each lane with its counterpart in the other half, then in the other pair of its half,
    // then with its neighbour. After these three steps, every lane holds the minimum.
    let lanes = lanes.min(S::permute(lanes, 0x03_02_01_00_07_06_05_04));
    let lanes = lanes.min(S::permute(lanes, 0x05_04_07_06_01_00_03_02));
    let mut numbers = [0.0; 8];
    lanes.min(S::permute(lanes, 0x06_07_04_05_02_03_00_01)).store(&mut numbers);
    numbers[0]
}
