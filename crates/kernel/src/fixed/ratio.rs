//! Represents t as an exact ratio of integers that can be compared exactly.

use core::cmp::Ordering;

use super::numbers::pow2;
use super::quotient::{parts, quotient};

/// A positive t in multiples of the snapped direction: `num / den`, exact but not reduced.
///
/// Within the bit budgets, `num <= 2^64` and `den < 2^62`, so the product of one ratio's numerator
/// and another's denominator fits in 128 bits.
///
/// ```
/// use intertri::fixed::{Bits, Grid, scalar};
/// use std::cmp::Ordering;
/// let grid = Grid::at(Bits::FINE, 0, [0; 3])?;
/// let wall = grid.triangle_of([[0, 0, 1], [4, 0, 1], [0, 4, 1]])?;
/// let t = scalar::crossing(&grid.ray_of([1, 1, 0], [0, 0, 3])?, &wall).unwrap().t;
/// assert_eq!(3 * t.num(), t.den().into());
/// assert_eq!(t.to_f64(0), 1.0 / 3.0);
/// // No f32 equals one third.
/// assert_eq!(t.cmp_f32(1.0 / 3.0), Some(Ordering::Less));
/// # Ok::<_, intertri::fixed::GridError>(())
/// ```
#[derive(Clone, Copy, Debug)]
pub struct Ratio {
    pub(super) num: u128,
    pub(super) den: u64,
}

impl Ratio {
    /// Returns the numerator, which is positive.
    pub fn num(self) -> u128 {
        self.num
    }

    /// Returns the denominator, which is positive.
    pub fn den(self) -> u64 {
        self.den
    }

    /// Converts `num / den * 2^exponent` to the nearest f64, ties to even. Pass the exponent of the
    /// ray: [`Ray::exponent`](super::Ray::exponent).
    #[inline]
    pub fn to_f64(self, exponent: i32) -> f64 {
        if self.num < 1 << 62 {
            let (nearest, is_sure) = quotient(parts(self.num as u64), parts(self.den));
            if is_sure {
                return nearest * pow2(exponent);
            }
        }
        self.divide(exponent)
    }

    /// Like [`Ratio::to_f64`], but by integer division.
    #[cold]
    #[inline(never)]
    pub(super) fn divide(self, exponent: i32) -> f64 {
        // A quotient of at least 56 bits, with a sticky bit for the remainder, rounds like the
        // ratio itself.
        let shift = (56 + bits(u128::from(self.den)) - bits(self.num)).max(0);
        let den = u128::from(self.den);
        let num = self.num << shift;
        let quotient = num / den;
        let sticky = u128::from(quotient * den != num);
        (quotient | sticky) as f64 * pow2(exponent - shift)
    }

    /// Compares `num / den` with an f32 exactly. Returns `None` for NaN.
    pub fn cmp_f32(self, x: f32) -> Option<Ordering> {
        if x.is_nan() {
            return None;
        }
        if x <= 0.0 {
            return Some(Ordering::Greater);
        }
        if x == f32::INFINITY {
            return Some(Ordering::Less);
        }
        // Let x = m * 2^e, and compare num with m * den * 2^e. Take m and e from the bits of x,
        // because a CPU that treats subnormal numbers as zero would read a subnormal x as 0.
        let field = (x.to_bits() >> 23) as i32;
        let fraction = x.to_bits() & 0x7f_ffff;
        let (m, shift) =
            if field == 0 { (fraction, -149) } else { (fraction | 1 << 23, field - 150) };
        let (left, right) = (self.num, u128::from(m) * u128::from(self.den));
        // If the bit lengths differ, they decide. If they are equal, the shift loses no bits.
        Some((bits(left)).cmp(&(bits(right) + shift)).then_with(|| {
            if shift < 0 { (left << -shift).cmp(&right) } else { left.cmp(&(right << shift)) }
        }))
    }

    /// Returns whether t is within the interval of a snapped ray. Returns false for NaN.
    pub(super) fn within(self, ray: &crate::Ray) -> bool {
        self.cmp_f32(ray.t_min).is_some_and(Ordering::is_ge)
            && self.cmp_f32(ray.t_max).is_some_and(Ordering::is_lt)
    }
}

/// Ratios are equal if their values are, whether or not they are reduced.
impl PartialEq for Ratio {
    #[inline(always)]
    fn eq(&self, other: &Self) -> bool {
        self.cmp(other).is_eq()
    }
}
impl Eq for Ratio {}
impl PartialOrd for Ratio {
    #[inline(always)]
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}
impl Ord for Ratio {
    #[inline(always)]
    fn cmp(&self, other: &Self) -> Ordering {
        // Both denominators are positive, so cross-multiply. The product of a number of at most
        // 2^64 and a number below 2^62 fits in 128 bits.
        (self.num * u128::from(other.den)).cmp(&(other.num * u128::from(self.den)))
    }
}

/// Returns the bit length of a positive integer.
fn bits(x: u128) -> i32 {
    128 - x.leading_zeros() as i32
}
