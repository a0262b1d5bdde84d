//! Attacks the limits of the integers.

use super::{SignBits, in_64_bits, in_lanes};
use crate::exact::test_numbers::random;
use crate::simd::{Ints, Lanes, Level, Simd, WithSimd};

/// Computes the signs of volumes, in 64 bits and in wider integers, if the level has them.
struct In<'a>(&'a [[f64; 8]; 17], &'a [[f64; 8]; 4]);
impl WithSimd for In<'_> {
    type Output = [Option<[SignBits; 4]>; 2];
    #[inline(always)]
    fn run<S: Simd>(self) -> Self::Output {
        let bounds = self.1.each_ref().map(|bounds| Lanes::load(bounds));
        let narrow = in_64_bits::<S>(self.0);
        let other = in_lanes::<S::F64x8, S::I64x8>(self.0, narrow.units).volumes(&bounds).0;
        let wide = in_lanes::<S::F64x8, S::WideInts>(self.0, narrow.units).volumes(&bounds).0;
        let narrow = narrow.volumes(&bounds).0;
        // Both conversions to 64 bits find the same signs.
        for (signs, other) in narrow.iter().flatten().zip(other.iter().flatten()) {
            assert_eq!(signs & !other, 0);
        }
        [Some(narrow), (S::WideInts::BITS > 64).then_some(wide)]
    }
}

/// 2^-32: with a coordinate like this one, edges' volumes have a unit of 2^-64 instead of 1, and the
/// limit of 128 bits is that of 64 bits without it.
const FRACTION: f64 = 1.0 / (1_u64 << 32) as f64;

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
        let mut rows = [[0.0; 8]; 17];
        for (row, x) in rows.iter_mut().zip(points.iter().chain(&dir)) {
            *row = [*x; 8];
        }
        for level in Level::all() {
            for signs in level.run(In(&rows, &[[1e-300; 8]; 4])).into_iter().flatten() {
                for [positive, negative, zero] in &signs[..zeros] {
                    assert_eq!((*positive, *negative, *zero), (0, 0, 0xff), "{level:?}");
                }
                assert!(zeros == 4 || signs[3][2] == 0, "{level:?}");
            }
        }
    }
}

/// Checks the signs in a lane. Counts those that are left open, those that are found, and among these
/// the ones of numbers beyond 2^62.
fn check((signs, lane): (SignBits, usize), truth: i128, bound: f64, counts: &mut [u32; 3]) {
    // The precondition: f64 has left the number open.
    if truth.unsigned_abs() as f64 > 2.0 * bound {
        return;
    }
    let signs = signs.map(|bits| bits >> lane & 1 != 0);
    if signs == [false; 3] {
        counts[0] += 1;
        return;
    }
    assert_eq!(signs, [truth > 0, truth < 0, truth == 0], "{truth}");
    counts[1] += 1;
    counts[2] += u32::from(truth.unsigned_abs() > 1 << 62);
}

/// Attacks the range: U is a small multiple of 2^60, and its bound is around 2^62. The edge from
/// the short B to the long C is nearly met, because d = m C + B, and B is then moved by a few units.
#[test]
fn volumes_at_the_limit_have_their_signs() {
    let (mut random, mut counts) = (random(), [[0; 3]; 2]);
    for i in 0..40_000 {
        let (mut rows, mut bounds) = ([[0.0; 8]; 17], [[f64::INFINITY; 8]; 4]);
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
            // The first corner is not part of U.
            rows[1][lane] = if i % 2 == 0 { rows[1][lane] } else { 3.0 * FRACTION };
            let ([d, b, c], mut permanent) = ([d, b, c].map(|v| v.map(i128::from)), 0);
            for (i, j, k) in [(0, 1, 2), (1, 2, 0), (2, 0, 1)] {
                let (p, q) = (d[i] * b[j] * c[k], d[i] * b[k] * c[j]);
                truth[lane] += p - q;
                permanent += p.abs() + q.abs();
            }
            bounds[0][lane] = 4.0 * f64::EPSILON * permanent as f64;
        }
        for level in Level::all() {
            // 64 bits are attacked without the fraction, and 128 bits with it.
            let Some(signs) = level.run(In(&rows, &bounds))[i % 2] else { continue };
            for (lane, truth) in truth.iter().enumerate() {
                check((signs[0], lane), *truth, bounds[0][lane], &mut counts[i % 2]);
            }
        }
    }
    for counts in &counts[..=usize::from(Level::avx512().is_some())] {
        assert!(counts.iter().all(|count| *count > 1000), "{counts:?}");
    }
}

struct NormalsIn<'a>(&'a [[f64; 8]; 17], &'a [[[f64; 8]; 3]; 3]);
impl WithSimd for NormalsIn<'_> {
    type Output = [Option<[[SignBits; 3]; 3]>; 2];
    #[inline(always)]
    fn run<S: Simd>(self) -> Self::Output {
        let bounds = self.1.each_ref().map(|of| of.each_ref().map(|bounds| Lanes::load(bounds)));
        let narrow = in_64_bits::<S>(self.0);
        let wide = in_lanes::<S::F64x8, S::WideInts>(self.0, narrow.units).normals(&bounds);
        [Some(narrow.normals(&bounds)), (S::WideInts::BITS > 64).then_some(wide)]
    }
}

/// Attacks the range of the normals' components: B × C is around 2^63 and its bound around 2^62,
/// because C = m B + e with a short e.
#[test]
fn normals_at_the_limit_have_their_signs() {
    let (mut random, mut counts) = (random(), [[0; 3]; 2]);
    for i in 0..40_000 {
        let (mut rows, mut bounds) = ([[0.0; 8]; 17], [[[f64::INFINITY; 8]; 3]; 3]);
        let mut truth = [[0_i128; 3]; 8];
        for lane in 0..8 {
            let mut vec3 = |size: f64| [0; 3].map(|_| (2.0 * size * random()).round() as i128);
            let (b, e, m) = (vec3(2_f64.powi(51)), vec3(24.0), vec3(3.0)[0]);
            let b = b.map(|x| 16 * x);
            let c = [0, 1, 2].map(|k| m * b[k] + 16 * e[k]);
            // The first corner determines the unit, 1 or a fraction.
            let numbers = [[1, 0, 0], b, c, [0; 3], [1, 2, 3]];
            for (row, x) in rows.iter_mut().zip(numbers.as_flattened()) {
                row[lane] = *x as f64;
                assert_eq!(row[lane] as i128, *x);
            }
            rows[0][lane] = if i % 2 == 0 { 1.0 } else { FRACTION };
            for (k, (p, q)) in [(1, 2), (2, 0), (0, 1)].into_iter().enumerate() {
                let (x, y) = (b[p] * c[q], b[q] * c[p]);
                truth[lane][k] = x - y;
                bounds[0][k][lane] = 3.0 * f64::EPSILON * (x.abs() + y.abs()) as f64;
            }
            if i % 16 == 0 {
                // Without a bound, nothing is known.
                bounds[0][0][lane] = f64::NAN;
            }
        }
        for level in Level::all() {
            let Some(signs) = level.run(NormalsIn(&rows, &bounds))[i % 2] else { continue };
            for (lane, truth) in truth.iter().enumerate() {
                for (k, truth) in truth.iter().enumerate() {
                    check((signs[0][k], lane), *truth, bounds[0][k][lane], &mut counts[i % 2]);
                }
            }
        }
    }
    for counts in &counts[..=usize::from(Level::avx512().is_some())] {
        assert!(counts.iter().all(|count| *count > 200), "{counts:?}");
    }
}

struct EndIn<'a>(&'a [[f64; 8]; 17], &'a [f64; 8], &'a [f64; 8]);
impl WithSimd for EndIn<'_> {
    type Output = [Option<SignBits>; 2];
    #[inline(always)]
    fn run<S: Simd>(self) -> Self::Output {
        let (ends, bounds) = (Lanes::load(self.1), Lanes::load(self.2));
        let all = in_64_bits::<S>(self.0);
        let (_, t_and_d) = all.volumes(&[Lanes::splat(f64::NAN); 4]);
        let found = all.end(t_and_d, ends, bounds);

        // Wider integers also find the signs of ends that are beyond the limit of 64 bits.
        let wide = in_lanes::<S::F64x8, S::WideInts>(self.0, all.units);
        let (_, t_and_d) = wide.volumes(&[Lanes::splat(f64::NAN); 4]);
        let wide = wide.end(t_and_d, ends, bounds);
        [Some(found), (S::WideInts::BITS > 64).then_some(wide)]
    }
}

/// Attacks the range of `T - e D`, which is around 2^63, with a bound around 2^62: A = e d + s with a
/// short s, so that the difference is s·N. The unit of e is smaller than 1, as large as that of
/// points, or larger.
#[test]
fn ends_at_the_limit_have_their_signs() {
    let (mut random, mut counts) = (random(), [[0; 3]; 2]);
    for i in 0..40_000 {
        let (mut rows, mut end, mut bounds) = ([[0.0; 8]; 17], [0.0; 8], [f64::NAN; 8]);
        let mut truth = [0_i128; 8];
        for lane in 0..8 {
            let mut vec3 = |size: f64| [0; 3].map(|_| (2.0 * size * random()).round() as i128);
            let (g, s, h4, h5) = (vec3(3e11), vec3(12.0), vec3(1e9), vec3(1e9));
            let m = 2 * (vec3(1000.0)[0].abs()) + 1;
            // e = m/8 and d = 8 g, e = m and d = g, or e = 8 m and d = g.
            let (e, d, times) = match i % 3 {
                0 => (m as f64 / 8.0, g.map(|x| 8 * x), m),
                1 => (m as f64, g, m),
                _ => (8.0 * m as f64, g, 8 * m),
            };
            let a = [0, 1, 2].map(|k| times * g[k] + s[k]);
            let plus = |h: [i128; 3]| [0, 1, 2].map(|k| a[k] + h[k]);
            let numbers = [a, plus(h4), plus(h5), [0; 3], d];
            for (row, x) in rows.iter_mut().zip(numbers.as_flattened()) {
                row[lane] = *x as f64;
                assert_eq!(row[lane] as i128, *x);
            }
            let (mut of_t, mut of_d) = (0, 0);
            for (x, (y, z)) in [(0, (1, 2)), (1, (2, 0)), (2, (0, 1))] {
                let (p, q) = (h4[y] * h5[z], h4[z] * h5[y]);
                truth[lane] += s[x] * (p - q);
                of_t += a[x].abs() * (p.abs() + q.abs());
                of_d += d[x].abs() * (p.abs() + q.abs());
            }
            end[lane] = e;
            bounds[lane] = 8.0 * f64::EPSILON * (of_t as f64 + e * of_d as f64);
        }
        for level in Level::all() {
            for (signs, counts) in
                level.run(EndIn(&rows, &end, &bounds)).into_iter().zip(&mut counts)
            {
                for (lane, truth) in truth.iter().enumerate() {
                    if let Some(signs) = signs {
                        check((signs, lane), *truth, bounds[lane], counts);
                    }
                }
            }
        }
    }
    let [narrow, wide] = counts;
    assert!(narrow.iter().all(|count| *count > 1000), "{counts:?}");
    assert!(wide[0] == 0 && (wide[1] > 1000 || Level::avx512().is_none()), "{counts:?}");
}
