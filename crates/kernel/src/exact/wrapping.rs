//! The signs of volumes that f64 leaves open, from integers of 64 or 128 bits that may wrap, in lanes.
//!
//! ```text
//!   x = n·2^l    n mod 2^64           f64 leaves V open only if |V| ≤ 2E. If 2E < 2^63·ω, where ω is
//!   V / ω = d·(B × C) mod 2^64        the unit of V, the integer modulo 2^64 is V / ω itself, however
//!                                     often the steps before it wrapped. The same holds for 2^127.
//! ```
//!
//! `docs/numerics/exact.md`, section 4, has the proof.

use super::decision::Rule;
use super::float::{Bounds, NormalSigns, Signs};
use super::quotient::pow2;
use crate::packet::RayLanes;
use crate::simd::{Ints, Lanes, Mask, Simd, Vec3};

/// The signs of a number in eight pairs: bits of the lanes in which it is certainly positive,
/// negative, and 0.
type SignBits = [u32; 3];

/// The coordinates of pairs, one in each lane, as integers that wrap.
pub(super) struct Wrapped<F, I> {
    corners: [[I; 3]; 3],
    origin: [I; 3],
    dir: [I; 3],
    /// The units of all points and of the direction, which are powers of two, or infinite if all
    /// numbers are 0.
    pub(super) units: [F; 2],
    /// The lanes in which the integers are the coordinates.
    converted: u32,
}

/// 1.5 * 2^52: adding this number moves an integer of up to 51 binary digits to the lowest bits.
const TO_INTEGER: f64 = 1.5 * (1_u64 << 52) as f64;

/// 2^51, the limit of such integers.
const SHORT: f64 = (1_u64 << 51) as f64;

/// 2^40: longer integers are divided by this number.
const PART: f64 = (1_u64 << 40) as f64;

/// Converts the corners, the origin, and the direction of eight pairs to 64-bit integers. In the lanes
/// whose results are used, no number may be subnormal, or as large or small as f64.md, section 3,
/// excludes.
#[inline(always)]
pub(super) fn in_64_bits<S: Simd>(rows: &[[f64; 8]; 17]) -> Wrapped<S::F64x8, S::I64x8> {
    let [rows @ .., _, _] = rows;
    // As one loop, because compilers turn a loop over rows into gathers.
    let mut others = [[0.0; 8]; 15];
    for (others, x) in others.as_flattened_mut().iter_mut().zip(rows.as_flattened()) {
        *others = without_lowest_digit(*x);
    }
    let (unit_of_points, most) = unit_and_largest::<S::F64x8>(&rows[..12], &others[..12]);
    let (unit_of_dirs, longest) = unit_and_largest::<S::F64x8>(&rows[12..], &others[12..]);
    let splat = <S::F64x8 as Lanes>::splat;
    let units = [unit_of_points, unit_of_dirs];
    let inverse = [splat(1.0) / units[0], splat(1.0) / units[1]];
    let largest = (most * inverse[0]).max(longest * inverse[1]);
    let converted = largest.lt(splat(SHORT * PART)).bits();
    let is_long = converted & !largest.lt(splat(SHORT)).bits() != 0;

    let [c1, c2, c3, origin, dir] = if is_long {
        integers::<S, true>(rows, inverse)
    } else {
        integers::<S, false>(rows, inverse)
    };
    Wrapped { corners: [c1, c2, c3], origin, dir, units, converted }
}

/// Returns, for each lane, the lowest binary digit and the largest magnitude of its numbers. `others` are
/// the numbers without their lowest digits.
#[inline(always)]
fn unit_and_largest<F: Lanes<Scalar = f64>>(rows: &[[f64; 8]], others: &[[f64; 8]]) -> (F, F) {
    let (mut unit, mut largest) = (F::splat(f64::INFINITY), F::splat(0.0));
    for (row, others) in rows.iter().zip(others) {
        let x = F::load(row);
        let digit = (x - F::load(others)).abs();
        unit = F::select(digit.le(F::splat(0.0)), unit, digit.min(unit));
        largest = x.abs().max(largest);
    }
    (unit, largest)
}

/// Converts the same numbers to integers of any width, given the units that [`in_64_bits`] has found.
#[inline(always)]
pub(super) fn in_lanes<F: Lanes<Scalar = f64>, I: Ints>(
    rows: &[[f64; 8]; 17],
    units: [F; 2],
) -> Wrapped<F, I> {
    let mut of = [[0.0; 8]; 2];
    units[0].store(&mut of[0]);
    units[1].store(&mut of[1]);
    let mut all = [[I::splat(0); 3]; 5];
    for (i, (to, row)) in all.as_flattened_mut().iter_mut().zip(rows).enumerate() {
        // Write each number as an odd integer times a power of two.
        let (mut odd, mut exponents) = ([0; 8], [0; 8]);
        for lane in 0..8 {
            let lowest = exponent(row[lane] - without_lowest_digit(row[lane]));
            let bits = row[lane].to_bits();
            let zeros = lowest - exponent(row[lane]) + 52;
            let size = (bits & ((1 << 52) - 1) | 1 << 52) >> (zeros & 63);
            let size = if bits << 1 == 0 { 0 } else { size as i64 };
            // Negate the negative numbers: -1 is the complement of 0.
            let sign = bits as i64 >> 63;
            odd[lane] = (size ^ sign) - sign;
            exponents[lane] = lowest - exponent(of[i / 12][lane]);
        }
        *to = I::shifted(&odd, &exponents);
    }
    let [c1, c2, c3, origin, dir] = all;
    Wrapped { corners: [c1, c2, c3], origin, dir, units, converted: u32::MAX }
}

impl<F: Lanes<Scalar = f64>, I: Ints> Wrapped<F, I> {
    /// A number fits in the integers if the bound on its error is below this many of its units: 2^62,
    /// or 2^126.
    const LIMIT: f64 = pow2(I::BITS as i32 - 2);

    /// Returns the signs known so far, and those that integers find. `bounds` are bounds on the errors in
    /// f64. Only the `open` lanes matter.
    #[inline(always)]
    pub(super) fn add_signs(
        &self,
        (rule, open): (Rule, u32),
        corners: [Vec3<F>; 3],
        rays: &RayLanes<F>,
        known: &Signs<F::Mask>,
        (bounds, end_bounds): Bounds<F>,
    ) -> Signs<F::Mask> {
        let none = [Mask::from_bits(0); 3];
        let mut found = Signs { volumes: [none; 4], ends: [none; 2], edges: none };
        let (volumes, t_and_d) = self.volumes(&bounds);
        for (masks, bits) in found.volumes.iter_mut().zip(volumes) {
            *masks = masks_of(bits);
        }
        // Few rays end on a triangle.
        for (i, end) in [rays.t_min, rays.t_max].into_iter().enumerate() {
            let [over, under, at] = known.ends[i];
            if open & !(over | under | at).bits() != 0 {
                found.ends[i] = masks_of(self.end(t_and_d, end, end_bounds[i]));
            }
        }
        let mut signs = known.or(&found);
        // For hits, T and D have the same sign. If both are negative, so are the factors of the ends.
        let [_, _, _, [_, negative, _]] = signs.volumes;
        for (end, known) in signs.ends.iter_mut().zip(&known.ends) {
            let open = !(known[0] | known[1] | known[2]) & negative;
            let [over, under, at] = *end;
            *end = [open & under | !open & over, open & over | !open & under, at];
        }
        // Where a volume is 0, the *once* rule needs the signs of a normal.
        let [[_, _, u], [_, _, v], [_, _, w], _] = signs.volumes;
        if rule == Rule::Closed || (u | v | w).bits() & open == 0 {
            return signs;
        }
        let mut normals = NormalSigns::new(corners, rays.org);
        for (known, bits) in normals.signs.iter_mut().zip(self.normals(&normals.bounds)) {
            for (known, bits) in known.iter_mut().zip(bits) {
                let (open, more) = (!(known[0] | known[1] | known[2]), masks_of(bits));
                for (known, more) in known.iter_mut().zip(more) {
                    *known = *known | open & more;
                }
            }
        }
        signs.moved(&normals.signs)
    }

    /// Returns the signs of U, V, W, and T, which f64 has left open with these bounds on their
    /// errors, and T and D.
    #[inline(always)]
    fn volumes(&self, bounds: &[F; 4]) -> ([SignBits; 4], [I; 2]) {
        let Self { corners: [c1, c2, c3], origin, dir, .. } = *self;
        let (a, h4, h5) = (minus(c1, origin), minus(c2, c1), minus(c3, c1));
        let (moment, normal) = (cross(a, dir), cross(h4, h5));
        let (v, minus_w) = (dot(h5, moment), dot(h4, moment));
        let (zero, den) = (I::splat(0), dot(dir, normal));
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
    fn end(&self, [t, den]: [I; 2], ends: F, bounds: F) -> SignBits {
        let (mut units, mut errors, mut numbers) = ([[0.0; 8]; 2], [0.0; 8], [0.0; 8]);
        self.units[0].store(&mut units[0]);
        self.units[1].store(&mut units[1]);
        bounds.store(&mut errors);
        ends.store(&mut numbers);
        // The difference is `of_t 2^by_t - of_d 2^by_d`, with an odd factor of D.
        let (mut odd, mut by_t, mut by_d, mut in_range) = ([0; 8], [0; 8], [0; 8], 0);
        for lane in 0..F::N {
            // Write the end as an odd integer times a power of two.
            let bits = numbers[lane].to_bits();
            let digits = bits & ((1 << 52) - 1) | 1 << 52;
            let zeros = digits.trailing_zeros();
            odd[lane] = (digits >> zeros) as i64;

            // The units of T and of `end D` are powers of two, and that of the difference is the
            // smaller one.
            let [points, dirs] = [exponent(units[0][lane]), exponent(units[1][lane])];
            let unit_of_t = 3 * points;
            let unit_of_d = 2 * points + dirs + exponent(numbers[lane]) - 52 + i64::from(zeros);
            let unit = if unit_of_t < unit_of_d { unit_of_t } else { unit_of_d };
            (by_t[lane], by_d[lane]) = (unit_of_t - unit, unit_of_d - unit);
            let is_normal = UNITS[0] <= unit && unit <= UNITS[1];
            in_range |=
                u32::from(is_normal && errors[lane] < pow2(unit as i32) * Self::LIMIT) << lane;
        }
        let difference = t.times(I::shifted(&[1; 8], &by_t)) - den.times(I::shifted(&odd, &by_d));
        sign_bits(difference, in_range & self.converted)
    }

    /// Returns the signs of the components of N₁ = B × C, N₂ = C × A, and N₃ = A × B, which f64 has
    /// left open with these bounds on their errors.
    #[inline(always)]
    fn normals(&self, bounds: &[[F; 3]; 3]) -> [[SignBits; 3]; 3] {
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
    fn signs(&self, number: I, unit: F, bound: F) -> SignBits {
        let in_range = bound.lt(unit * F::splat(Self::LIMIT)).bits();
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

/// The exponents of units for which `2^62` units are a normal number, and `2^126` units a normal number
/// or infinite. Only those of products with an end of an interval may be outside.
const UNITS: [i64; 2] = [-1000, 900];

/// Returns the exponent of a number that is not 0 or subnormal.
#[inline(always)]
fn exponent(x: f64) -> i64 {
    (x.to_bits() >> 52 & 0x7ff) as i64 - 1023
}

#[inline(always)]
fn masks_of<M: Mask>([positive, negative, zero]: SignBits) -> [M; 3] {
    [M::from_bits(positive), M::from_bits(negative), M::from_bits(zero)]
}

/// Returns the signs of a number in these lanes.
#[inline(always)]
fn sign_bits<I: Ints>(number: I, lanes: u32) -> SignBits {
    let (negative, zero) = (number.negative(), number.zero());
    [!(negative | zero) & lanes, negative & lanes, zero & lanes]
}

/// Replaces the lowest binary digit of a number by 0. Powers of two become 0.
#[inline(always)]
fn without_lowest_digit(x: f64) -> f64 {
    let bits = x.to_bits();
    let is_power = bits & ((1 << 52) - 1) == 0;
    f64::from_bits(if is_power { 0 } else { bits & bits.wrapping_sub(1) })
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
mod tests;
