//! The signs of volumes that f64 leaves open, from 64-bit integers that may wrap, in lanes.
//!
//! ```text
//!   x = n·2^l    n mod 2^64           f64 leaves V open only if |V| ≤ 2E. If 2E < 2^63·ω, where ω is
//!   V / ω = d·(B × C) mod 2^64        the unit of V, the integer modulo 2^64 is V / ω itself, however
//!                                     often the steps before it wrapped.
//! ```
//!
//! `docs/numerics/exact.md`, section 4, has the proof.

use crate::simd::{Ints, Lanes, Mask, Simd};

/// The signs of a number in eight pairs: bits of the lanes in which it is certainly positive,
/// negative, and 0.
pub(super) type SignBits = [u32; 3];

/// The coordinates of eight pairs as integers modulo 2^64.
pub(super) struct Wrapped<S: Simd> {
    corners: [[S::I64x8; 3]; 3],
    origin: [S::I64x8; 3],
    dir: [S::I64x8; 3],
    /// The units of all points and of the direction, which are powers of two, or infinite if all
    /// numbers are 0.
    units: [S::F64x8; 2],
    /// The lanes in which the integers are the coordinates.
    converted: u32,
}

/// 1.5 * 2^52: adding this number moves an integer of up to 51 binary digits to the lowest bits.
const TO_INTEGER: f64 = 1.5 * (1_u64 << 52) as f64;

/// 2^51, the limit of such integers.
const SHORT: f64 = (1_u64 << 51) as f64;

/// 2^40: longer integers are divided by this number.
const PART: f64 = (1_u64 << 40) as f64;

/// 2^62: a number fits in 64 bits if the bound on its error is below this many of its units.
const LIMIT: f64 = (1_u64 << 62) as f64;

impl<S: Simd> Wrapped<S> {
    /// Converts the corners, the origin, and the direction, which the rows hold in f64. In the lanes
    /// whose results are used, no number may be subnormal, or as large or small as f64.md, section
    /// 3, excludes.
    #[inline(always)]
    pub(super) fn new(rows: &[[f64; 8]; 15]) -> Self {
        let mut others = [[0.0; 8]; 15];
        for (others, row) in others.iter_mut().zip(rows) {
            clear_lowest_digit(row, others);
        }
        // The unit is the lowest digit of any number.
        let splat = <S::F64x8 as Lanes>::splat;
        let (mut units, mut most) = ([splat(f64::INFINITY); 2], [splat(0.0); 2]);
        for (i, (row, others)) in rows.iter().zip(&others).enumerate() {
            let (x, unit) = (S::F64x8::load(row), units[i / 12]);
            let digit = (x - S::F64x8::load(others)).abs();
            let is_zero = digit.le(splat(0.0));
            units[i / 12] = S::F64x8::select(is_zero, unit, digit.min(unit));
            most[i / 12] = x.abs().max(most[i / 12]);
        }
        let inverse = [splat(1.0) / units[0], splat(1.0) / units[1]];
        let largest = (most[0] * inverse[0]).max(most[1] * inverse[1]);
        let converted = largest.lt(splat(SHORT * PART)).bits();
        let is_long = converted & !largest.lt(splat(SHORT)).bits() != 0;

        let [c1, c2, c3, origin, dir] = if is_long {
            integers::<S, true>(rows, inverse)
        } else {
            integers::<S, false>(rows, inverse)
        };
        Self { corners: [c1, c2, c3], origin, dir, units, converted }
    }

    /// Returns the signs of U, V, W, and T, which f64 has left open with these bounds on their
    /// errors, and T and D.
    #[inline(always)]
    pub(super) fn volumes(&self, bounds: &[S::F64x8; 4]) -> ([SignBits; 4], [S::I64x8; 2]) {
        let Self { corners: [c1, c2, c3], origin, dir, .. } = *self;
        let (a, h4, h5) = (minus(c1, origin), minus(c2, c1), minus(c3, c1));
        let (moment, normal) = (cross(a, dir), cross(h4, h5));
        let (v, minus_w) = (dot(h5, moment), dot(h4, moment));
        let (zero, den) = (S::I64x8::splat(0), dot(dir, normal));
        let (w, u, t) = (zero - minus_w, den - v + minus_w, dot(a, normal));

        let [points, dirs] = self.units;
        let (square, [of_u, of_v, of_w, of_t]) = (points * points, *bounds);
        let edge = square * dirs;
        let signs = [
            self.signs(u, edge, of_u),
            self.signs(v, edge, of_v),
            self.signs(w, edge, of_w),
            self.signs(t, square * points, of_t),
        ];
        (signs, [t, den])
    }

    /// Returns the signs of `T - end D`, which f64 has left open with these bounds on their errors. An
    /// end must be positive and not subnormal in the lanes whose results are used.
    #[inline(always)]
    pub(super) fn end(
        &self,
        [t, den]: [S::I64x8; 2],
        end: &[f64; 8],
        bounds: S::F64x8,
    ) -> SignBits {
        let (mut of_t, mut of_d, mut errors) = ([0; 8], [0; 8], [0.0; 8]);
        t.store(&mut of_t);
        den.store(&mut of_d);
        bounds.store(&mut errors);
        let mut units = [[0.0; 8]; 2];
        self.units[0].store(&mut units[0]);
        self.units[1].store(&mut units[1]);
        let mut in_range = 0;
        for lane in 0..8 {
            // Write the end as an odd integer times a power of two.
            let bits = end[lane].to_bits();
            let digits = bits & ((1 << 52) - 1) | 1 << 52;
            let zeros = digits.trailing_zeros();
            let odd = (digits >> zeros) as i64;

            // The units of T and of `end D` are powers of two, and that of the difference is the
            // smaller one.
            let [points, dirs] = [exponent(units[0][lane]), exponent(units[1][lane])];
            let unit_of_t = 3 * points;
            let unit_of_d = 2 * points + dirs + exponent(end[lane]) - 52 + i64::from(zeros);
            let unit = if unit_of_t < unit_of_d { unit_of_t } else { unit_of_d };
            let product = of_d[lane].wrapping_mul(odd);
            of_t[lane] = shifted(of_t[lane], unit_of_t - unit)
                .wrapping_sub(shifted(product, unit_of_d - unit));
            let limit = f64::from_bits(((1023 + unit) as u64) << 52) * LIMIT;
            let is_normal = UNITS[0] <= unit && unit <= UNITS[1];
            in_range |= u32::from(is_normal && errors[lane] < limit) << lane;
        }
        sign_bits(<S::I64x8 as Ints>::load(&of_t), in_range & self.converted)
    }

    /// Returns the signs of the components of N₁ = B × C, N₂ = C × A, and N₃ = A × B, which f64 has
    /// left open with these bounds on their errors.
    #[inline(always)]
    pub(super) fn normals(&self, bounds: &[[S::F64x8; 3]; 3]) -> [[SignBits; 3]; 3] {
        let Self { corners: [c1, c2, c3], origin, units: [points, _], .. } = *self;
        let (a, b, c) = (minus(c1, origin), minus(c2, origin), minus(c3, origin));
        let (mut signs, unit) = ([[[0; 3]; 3]; 3], points * points);
        for (i, normal) in [cross(b, c), cross(c, a), cross(a, b)].into_iter().enumerate() {
            for (k, component) in normal.into_iter().enumerate() {
                signs[i][k] = self.signs(component, unit, bounds[i][k]);
            }
        }
        signs
    }

    /// Returns the signs of a number with the given unit, and a bound on its error.
    #[inline(always)]
    fn signs(&self, number: S::I64x8, unit: S::F64x8, bound: S::F64x8) -> SignBits {
        let in_range = bound.lt(unit * Lanes::splat(LIMIT)).bits();
        sign_bits(number, in_range & self.converted)
    }
}

/// Returns all rows as integers modulo 2^64, given the inverses of the units of points and of the
/// direction. With `LONG`, they may have up to 91 binary digits, otherwise up to 51.
#[inline(always)]
fn integers<S: Simd, const LONG: bool>(
    rows: &[[f64; 8]; 15],
    inverse: [S::F64x8; 2],
) -> [[S::I64x8; 3]; 5] {
    let splat = <S::F64x8 as Lanes>::splat;
    let mut all = [[S::I64x8::splat(0); 3]; 5];
    for (i, (to, row)) in all.as_flattened_mut().iter_mut().zip(rows).enumerate() {
        let mut low = S::F64x8::load(row) * inverse[i / 12];
        if LONG {
            let sum = low * splat(1.0 / PART) + splat(TO_INTEGER);
            low = low - (sum - splat(TO_INTEGER)) * splat(PART);
            *to = lowest_bits::<S>(sum).times(Ints::splat(PART as i64));
        }
        let low = lowest_bits::<S>(low + splat(TO_INTEGER));
        *to = if LONG { *to + low } else { low };
    }
    all
}

/// Returns the integer that was added to [`TO_INTEGER`].
#[inline(always)]
fn lowest_bits<S: Simd>(sum: S::F64x8) -> S::I64x8 {
    let mut lanes = [0.0; 8];
    sum.store(&mut lanes);
    let bits: &[i64; 8] = bytemuck::cast_ref(&lanes);
    <S::I64x8 as Ints>::load(bits) - Ints::splat(TO_INTEGER.to_bits() as i64)
}

/// The exponents of units for which `2^62` units are a normal number. Only those of products with an
/// end of an interval may be outside.
const UNITS: [i64; 2] = [-1000, 900];

/// Returns the exponent of a number that is not 0 or subnormal.
#[inline(always)]
fn exponent(x: f64) -> i64 {
    (x.to_bits() >> 52 & 0x7ff) as i64 - 1023
}

/// Multiplies a number by a power of two, modulo 2^64. The exponent is positive or 0.
#[inline(always)]
fn shifted(x: i64, by: i64) -> i64 {
    if by < 64 { x << (by & 63) } else { 0 }
}

/// Returns the signs of a number in these lanes.
#[inline(always)]
fn sign_bits<I: Ints>(number: I, lanes: u32) -> SignBits {
    let (negative, zero) = (number.negative(), number.zero());
    [!(negative | zero) & lanes, negative & lanes, zero & lanes]
}

/// Replaces the lowest binary digit of each number by 0. Powers of two become 0.
#[inline(always)]
fn clear_lowest_digit(row: &[f64; 8], to: &mut [f64; 8]) {
    for (to, x) in to.iter_mut().zip(row) {
        let bits = x.to_bits();
        let is_power = bits & ((1 << 52) - 1) == 0;
        *to = f64::from_bits(if is_power { 0 } else { bits & bits.wrapping_sub(1) });
    }
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
    use super::{SignBits, Wrapped};
    use crate::exact::test_numbers::random;
    use crate::simd::{Lanes, Level, Simd, WithSimd};

    struct In<'a>(&'a [[f64; 8]; 15], &'a [[f64; 8]; 4]);
    impl WithSimd for In<'_> {
        type Output = [SignBits; 4];
        #[inline(always)]
        fn run<S: Simd>(self) -> [SignBits; 4] {
            let bounds = self.1.each_ref().map(|bounds| Lanes::load(bounds));
            Wrapped::<S>::new(self.0).volumes(&bounds).0
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
                let signs = level.run(In(&rows, &bounds))[0];
                for (lane, truth) in truth.iter().enumerate() {
                    check((signs, lane), *truth, bounds[0][lane], &mut counts);
                }
            }
        }
        assert!(counts.iter().all(|count| *count > 1000), "{counts:?}");
    }

    struct NormalsIn<'a>(&'a [[f64; 8]; 15], &'a [[[f64; 8]; 3]; 3]);
    impl WithSimd for NormalsIn<'_> {
        type Output = [[SignBits; 3]; 3];
        #[inline(always)]
        fn run<S: Simd>(self) -> Self::Output {
            let bounds =
                self.1.each_ref().map(|of| of.each_ref().map(|bounds| Lanes::load(bounds)));
            Wrapped::<S>::new(self.0).normals(&bounds)
        }
    }

    /// Attacks the range of the normals' components: B × C is around 2^63 and its bound around 2^62,
    /// because C = m B + e with a short e.
    #[test]
    fn normals_at_the_limit_have_their_signs() {
        let (mut random, mut counts) = (random(), [0; 3]);
        for i in 0..40_000 {
            let (mut rows, mut bounds) = ([[0.0; 8]; 15], [[[f64::INFINITY; 8]; 3]; 3]);
            let mut truth = [[0_i128; 3]; 8];
            for lane in 0..8 {
                let mut vec3 = |size: f64| [0; 3].map(|_| (2.0 * size * random()).round() as i128);
                let (b, e, m) = (vec3(2_f64.powi(51)), vec3(24.0), vec3(3.0)[0]);
                let b = b.map(|x| 16 * x);
                let c = [0, 1, 2].map(|k| m * b[k] + 16 * e[k]);
                // The first corner determines the unit, 1.
                let numbers = [[1, 0, 0], b, c, [0; 3], [1, 2, 3]];
                for (row, x) in rows.iter_mut().zip(numbers.as_flattened()) {
                    row[lane] = *x as f64;
                    assert_eq!(row[lane] as i128, *x);
                }
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
                let signs = level.run(NormalsIn(&rows, &bounds))[0];
                for (lane, truth) in truth.iter().enumerate() {
                    for (k, truth) in truth.iter().enumerate() {
                        check((signs[k], lane), *truth, bounds[0][k][lane], &mut counts);
                    }
                }
            }
        }
        assert!(counts.iter().all(|count| *count > 1000), "{counts:?}");
    }

    struct EndIn<'a>(&'a [[f64; 8]; 15], &'a [f64; 8], &'a [f64; 8]);
    impl WithSimd for EndIn<'_> {
        type Output = SignBits;
        #[inline(always)]
        fn run<S: Simd>(self) -> SignBits {
            let all = Wrapped::<S>::new(self.0);
            let (_, t_and_d) = all.volumes(&[Lanes::splat(f64::NAN); 4]);
            all.end(t_and_d, self.1, Lanes::load(self.2))
        }
    }

    /// Attacks the range of `T - e D`, which is around 2^63, with a bound around 2^62: A = e d + s with a
    /// short s, so that the difference is s·N. The unit of e is smaller than 1, as large as that of
    /// points, or larger.
    #[test]
    fn ends_at_the_limit_have_their_signs() {
        let (mut random, mut counts) = (random(), [0; 3]);
        for i in 0..40_000 {
            let (mut rows, mut end, mut bounds) = ([[0.0; 8]; 15], [0.0; 8], [f64::NAN; 8]);
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
                let signs = level.run(EndIn(&rows, &end, &bounds));
                for (lane, truth) in truth.iter().enumerate() {
                    check((signs, lane), *truth, bounds[lane], &mut counts);
                }
            }
        }
        assert!(counts.iter().all(|count| *count > 1000), "{counts:?}");
    }
}
