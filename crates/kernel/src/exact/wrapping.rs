//! The signs of volumes that f64 leaves open, from 64-bit integers that may wrap, in lanes.
//!
//! ```text
//!   x = q·2^l    q mod 2^64           f64 leaves V open only if |V| ≤ 2E. If 2E < 2^63·ω, where ω is
//!   V / ω = d·(B × C) mod 2^64        the unit of V, the integer modulo 2^64 is V / ω itself, however
//!                                     often the steps before it wrapped.
//! ```
//!
//! `docs/numerics/exact.md`, section 4, has the proof.

use crate::simd::{Ints, Simd};

/// The signs of U, V, W, and T of eight pairs: bits of the lanes in which each is certainly
/// positive, negative, and 0.
pub(super) type SignBits = [[u32; 3]; 4];

/// Returns the signs of volumes that f64 has left open with these bounds on their errors. The rows
/// hold the corners, the origin, and the direction in f64. In the lanes whose results are used, no
/// number may be subnormal, or as large or small as f64.md, section 3, excludes.
#[inline(always)]
pub(super) fn signs<S: Simd>(rows: &[[f64; 8]; 15], bounds: &[[f64; 8]; 4]) -> SignBits {
    // Write each number as an odd integer times a power of two, and find the unit of all points
    // and that of the direction.
    let (mut odd, mut exponents) = ([[0; 8]; 15], [[0; 8]; 15]);
    let mut units = [[OF_ZERO; 8]; 2];
    for (i, row) in rows.iter().enumerate() {
        split(row, &mut odd[i], &mut exponents[i]);
        lower(&mut units[i / 12], &exponents[i]);
    }
    for (i, (odd, exponent)) in odd.iter_mut().zip(&exponents).enumerate() {
        scale(odd, exponent, &units[i / 12]);
    }

    let vec3 =
        |i: usize| [S::I64x8::load(&odd[i]), Ints::load(&odd[i + 1]), Ints::load(&odd[i + 2])];
    let (c1, c2, c3, o, d) = (vec3(0), vec3(3), vec3(6), vec3(9), vec3(12));
    let (a, h4, h5) = (minus(c1, o), minus(c2, c1), minus(c3, c1));
    let (moment, normal) = (cross(a, d), cross(h4, h5));
    let (v, minus_w) = (dot(h5, moment), dot(h4, moment));
    let (zero, den) = (S::I64x8::splat(0), dot(d, normal));
    let (w, u, t) = (zero - minus_w, den - v + minus_w, dot(a, normal));

    let mut signs = [[0; 3]; 4];
    for (i, volume) in [u, v, w, t].into_iter().enumerate() {
        let mut in_range = 0;
        for lane in 0..8 {
            let [points, dir] = [units[0][lane], units[1][lane]];
            let unit = if i < 3 { dir + 2 * points } else { 3 * points };
            in_range |= u32::from(bounds[i][lane] < limit(unit)) << lane;
        }
        let (negative, zero) = (volume.negative(), volume.zero());
        signs[i] = [!(negative | zero), negative, zero].map(|bits| bits & in_range);
    }
    signs
}

/// The exponent of 0, which is larger than that of any other number.
const OF_ZERO: i64 = 1 << 12;

/// Writes numbers as odd integers times powers of two.
#[inline(always)]
fn split(row: &[f64; 8], odd: &mut [i64; 8], exponents: &mut [i64; 8]) {
    for lane in 0..8 {
        let bits = row[lane].to_bits();
        let size = bits & (u64::MAX >> 1);
        let digits = size & ((1 << 52) - 1) | 1 << 52;
        let zeros = u64::from(digits.trailing_zeros());
        let (digits, sign) = ((digits >> zeros) as i64, bits as i64 >> 63);
        // Negate the digits if the sign is -1.
        let digits = (digits ^ sign) - sign;
        let exponent = (size >> 52) as i64 - 1075 + zeros as i64;
        (odd[lane], exponents[lane]) = if size == 0 { (0, OF_ZERO) } else { (digits, exponent) };
    }
}

/// Replaces each exponent by the smaller of two.
#[inline(always)]
fn lower(least: &mut [i64; 8], exponents: &[i64; 8]) {
    for (least, exponent) in least.iter_mut().zip(exponents) {
        *least = if *exponent < *least { *exponent } else { *least };
    }
}

/// Converts odd integers to numbers modulo 2^64, in units that divide them.
#[inline(always)]
fn scale(odd: &mut [i64; 8], exponents: &[i64; 8], units: &[i64; 8]) {
    for lane in 0..8 {
        let shift = exponents[lane] - units[lane];
        odd[lane] = if shift < 64 { odd[lane] << (shift & 63) } else { 0 };
    }
}

/// Returns the bound on errors below which the volume fits, given the exponent of its unit.
#[inline(always)]
fn limit(unit: i64) -> f64 {
    // 2^62 units. If there is no unit because all points or the direction are 0, this may be any
    // f64, and the volume is 0 as computed.
    f64::from_bits(((1023 + 62 + unit) as u64) << 52)
}

#[inline(always)]
fn minus<I: Ints>(a: [I; 3], b: [I; 3]) -> [I; 3] {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

#[inline(always)]
fn cross<I: Ints>(a: [I; 3], b: [I; 3]) -> [I; 3] {
    [
        a[1].times(b[2]) - a[2].times(b[1]),
        a[2].times(b[0]) - a[0].times(b[2]),
        a[0].times(b[1]) - a[1].times(b[0]),
    ]
}

#[inline(always)]
fn dot<I: Ints>(a: [I; 3], b: [I; 3]) -> I {
    a[0].times(b[0]) + a[1].times(b[1]) + a[2].times(b[2])
}

#[cfg(test)]
mod tests {
    use super::{SignBits, signs};
    use crate::exact::test_numbers::random;
    use crate::simd::{Level, Simd, WithSimd};

    struct In<'a>(&'a [[f64; 8]; 15], &'a [[f64; 8]; 4]);
    impl WithSimd for In<'_> {
        type Output = SignBits;
        #[inline(always)]
        fn run<S: Simd>(self) -> SignBits {
            signs::<S>(self.0, self.1)
        }
    }

    /// Zeros of both signs have no unit of their own. All volumes are 0 if all points are, and U, V,
    /// and W are 0 if the direction is.
    #[test]
    fn zeros_are_zeros() {
        let triangle = [5.0, 0.0, -0.0, 0.0, 7.0, 1.0, 2.0, 2.0, 9.0, 1.0, 1.0, -0.0];
        for (points, dir, zeros) in [
            ([-0.0; 12], [1.0, -2.0, -0.0], 4),
            ([0.0; 12], [-0.0, 0.0, -0.0], 4),
            (triangle, [0.0, -0.0, 0.0], 3),
        ] {
            let mut rows = [[0.0; 8]; 15];
            for (row, x) in rows.iter_mut().zip(points.iter().chain(&dir)) {
                *row = [*x; 8];
            }
            for level in Level::all() {
                let signs = level.run(In(&rows, &[[1e-300; 8]; 4]));
                for [positive, negative, _] in &signs[..zeros] {
                    assert_eq!((*positive, *negative), (0, 0), "{level:?}");
                }
                assert!(zeros == 4 || signs[3][2] == 0, "{level:?}");
            }
        }
    }

    /// Attacks the range: U is a small multiple of 2^60, and its bound is around 2^62. The edge from
    /// the short B to the long C is nearly met, because d = m C + B, and B is then moved by a few units.
    #[test]
    fn volumes_at_the_limit_have_their_signs() {
        let (mut random, mut counts) = (random(), [0; 3]);
        for _ in 0..40_000 {
            let (mut rows, mut bounds) = ([[0.0; 8]; 15], [[f64::INFINITY; 8]; 4]);
            let mut truth = [0_i128; 8];
            for lane in 0..8 {
                let mut vec3 = |size: f64| [0; 3].map(|_| (2.0 * size * random()) as i64);
                let (o, a, mut b, c) = (vec3(1e9), vec3(1e9), vec3(1e6), vec3(1e12));
                let m = (4096.0 * (1.0 + random())) as i64;
                let d = [0, 1, 2].map(|k| m * c[k] + b[k]);
                for x in &mut b {
                    *x += (12.0 * random()).round() as i64;
                }
                let numbers = [a, b, c].map(|corner| [0, 1, 2].map(|k| corner[k] + o[k]));
                let numbers = [numbers[0], numbers[1], numbers[2], o, d];
                for (row, x) in rows.iter_mut().zip(numbers.as_flattened()) {
                    row[lane] = *x as f64;
                    assert_eq!(row[lane] as i64, *x);
                }
                let ([d, b, c], mut permanent) = ([d, b, c].map(|v| v.map(i128::from)), 0);
                for (i, j, k) in [(0, 1, 2), (1, 2, 0), (2, 0, 1)] {
                    let (p, q) = (d[i] * b[j] * c[k], d[i] * b[k] * c[j]);
                    truth[lane] += p - q;
                    permanent += p.abs() + q.abs();
                }
                bounds[0][lane] = 4.0 * f64::EPSILON * permanent as f64;
            }
            for level in Level::all() {
                let [positive, negative, zero] = level.run(In(&rows, &bounds))[0];
                for (lane, truth) in truth.iter().enumerate() {
                    // The precondition: f64 has left the volume open.
                    if truth.unsigned_abs() as f64 > 2.0 * bounds[0][lane] {
                        continue;
                    }
                    let signs = [positive, negative, zero].map(|bits| bits >> lane & 1 != 0);
                    if signs == [false; 3] {
                        counts[0] += 1;
                        continue;
                    }
                    assert_eq!(signs, [*truth > 0, *truth < 0, *truth == 0], "{truth}");
                    counts[1] += 1;
                    counts[2] += u32::from(truth.unsigned_abs() > 1 << 62);
                }
            }
        }
        assert!(counts.iter().all(|count| *count > 1000), "{counts:?}");
    }
}
