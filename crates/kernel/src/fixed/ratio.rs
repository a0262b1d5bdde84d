//! t as an exact ratio of integers, and its comparisons.

use core::cmp::Ordering;

use super::numbers::pow2;
use super::quotient::{parts, quotient};

/// A positive t in multiples of the snapped direction: `num / den`, exact, not reduced.
///
/// Within the budgets `num <= 2^64` and `den < 2^62`, so the product of one's numerator and the other's
/// denominator fits 128 bits.
///
/// ```
/// use intertri::fixed::{Bits, Grid, scalar};
/// use std::cmp::Ordering;
/// let grid = Grid::at(Bits::FINE, 0, [0; 3])?;
/// let wall = grid.triangle_of([[0, 0, 1], [4, 0, 1], [0, 4, 1]])?;
/// let t = scalar::crossing(&grid.ray_of([1, 1, 0], [0, 0, 3])?, &wall).unwrap().t;
/// assert_eq!(3 * t.num(), t.den().into());
/// assert_eq!(t.to_f64(0), 1.0 / 3.0);
/// // No f32 is a third.
/// assert_eq!(t.cmp_f32(1.0 / 3.0), Some(Ordering::Less));
/// # Ok::<_, intertri::fixed::GridError>(())
/// ```
#[derive(Clone, Copy, Debug)]
pub struct Ratio {
    pub(super) num: u128,
    pub(super) den: u64,
}

impl Ratio {
    /// The numerator, positive.
    pub fn num(self) -> u128 {
        self.num
    }

    /// The denominator, positive.
    pub fn den(self) -> u64 {
        self.den
    }

    /// `num / den * 2^exponent`, correctly rounded to the nearest f64, ties to even. The exponent is one from
    /// [`Ray::exponent`](super::Ray::exponent).
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

    /// [`Ratio::to_f64`] by a division of integers.
    #[cold]
    #[inline(never)]
    pub(super) fn divide(self, exponent: i32) -> f64 {
        // A quotient of 56 bits or more, with a sticky bit for the remainder, rounds like the ratio.
        let shift = (56 + bits(u128::from(self.den)) - bits(self.num)).max(0);
        let den = u128::from(self.den);
        let num = self.num << shift;
        let quotient = num / den;
        let sticky = u128::from(quotient * den != num);
        (quotient | sticky) as f64 * pow2(exponent - shift)
    }

    /// Compares `num / den` with an f32, exactly. `None` for a NaN.
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
        // x = m * 2^e: compare num with m * den * 2^e.
        // Use the bits, so that a CPU that reads subnormal numbers as zero sees the same x.
        let field = (x.to_bits() >> 23) as i32;
        let fraction = x.to_bits() & 0x7f_ffff;
        let (m, shift) =
            if field == 0 { (fraction, -149) } else { (fraction | 1 << 23, field - 150) };
        let (left, right) = (self.num, u128::from(m) * u128::from(self.den));
        // The number of bits decides if they differ; if they are equal, the shift loses none.
        Some((bits(left)).cmp(&(bits(right) + shift)).then_with(|| {
            if shift < 0 { (left << -shift).cmp(&right) } else { left.cmp(&(right << shift)) }
        }))
    }

    /// Whether it is within the interval of a ray of integers; false for NaN.
    pub(super) fn within(self, ray: &crate::Ray) -> bool {
        self.cmp_f32(ray.t_min).is_some_and(Ordering::is_ge)
            && self.cmp_f32(ray.t_max).is_some_and(Ordering::is_lt)
    }
}

/// Equal as numbers, reduced or not.
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
        // Crosswise, as both denominators are positive: below 2^65 times below 2^62 fits 128 bits.
        (self.num * u128::from(other.den)).cmp(&(other.num * u128::from(self.den)))
    }
}

/// The number of bits of a positive number.
fn bits(x: u128) -> i32 {
    128 - x.leading_zeros() as i32
}
