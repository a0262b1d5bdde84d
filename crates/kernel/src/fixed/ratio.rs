//! t as an exact ratio of integers, and its comparisons.

use core::cmp::Ordering;

use super::numbers::{pow2, round, whole};

/// A positive t in multiples of the snapped direction: `num / den`, exact, not reduced.
///
/// Within the budgets `num <= 2^64` and `den < 2^62`, so that a product of one's numerator and the
/// other's denominator fits 128 bits.
///
/// ```
/// use intertri::fixed::{Bits, Grid, twin};
/// use std::cmp::Ordering;
/// let grid = Grid::at(Bits::FINE, 0, [0; 3])?;
/// let wall = grid.triangle_of([[0, 0, 1], [4, 0, 1], [0, 4, 1]])?;
/// let t = twin::crossing(&grid.ray_of([1, 1, 0], [0, 0, 3])?, &wall).unwrap().t;
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

    /// `num / den * 2^exponent` rounded once, to the nearest f64, ties to even. The exponent is one
    /// that [`Ray::exponent`](super::Ray::exponent) gives.
    pub fn to_f64(self, exponent: i32) -> f64 {
        // A quotient of 56 bits or more, and a sticky bit for what is left, round as the ratio does.
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
        let field = (x.to_bits() >> 23) as i32;
        let fraction = x.to_bits() & 0x7f_ffff;
        let (m, shift) =
            if field == 0 { (fraction, -149) } else { (fraction | 1 << 23, field - 150) };
        let (left, right) = (self.num, u128::from(m) * u128::from(self.den));
        // The number of bits decides where they differ; where they agree, the shift loses none.
        Some((bits(left)).cmp(&(bits(right) + shift)).then_with(|| {
            if shift < 0 { (left << -shift).cmp(&right) } else { left.cmp(&(right << shift)) }
        }))
    }

    /// Whether it lies in the interval of a ray of integers; false with a NaN.
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
        (self.num * u128::from(other.den)).cmp(&(other.num * u128::from(self.den)))
    }
}

/// A divisor, for quotients that are rounded once and take no division of integers.
pub(super) struct Divisor {
    den: u64,
    /// `1 / den`, but for two roundings.
    inverse: f64,
}

/// The implicit bit of an f64.
const ONE: u64 = 1 << 52;

impl Divisor {
    /// `None` from `2^60` on.
    #[inline(always)]
    pub(super) fn new(den: u64) -> Option<Self> {
        (den < 1 << 60).then(|| Self { den, inverse: 1.0 / den as f64 })
    }

    /// `num / den`, rounded to the nearest f64, and whether it is sure to be.
    #[inline(always)]
    pub(super) fn divides(&self, num: u64) -> (f64, bool) {
        // q is off by 4 of its last units at most. It is m of 53 bits times 2^-scale.
        let q = num as f64 * self.inverse;
        let bits = q.to_bits();
        let (scale, m) = (1075_u64.wrapping_sub(bits >> 52), (bits & (ONE - 1)) | ONE);

        // What it lacks: num 2^scale - m den, below 5 den < 2^63 in size, so that 64 bits tell it whatever
        // wraps. In units of den it is how many last units are missing, if that is not nearly a half.
        let shifted = if scale < 64 { num << scale } else { 0 };
        let lacks = shifted.wrapping_sub(m.wrapping_mul(self.den)) as i64 as f64 * self.inverse;
        let sure = (lacks - whole(lacks)).abs() < 0.499;

        // Near a power of two the last unit changes; from 2^53 on there are no units to lack.
        let inside = (bits.wrapping_add(8) & (ONE - 1)) > 16 && q < (2 * ONE) as f64;
        (f64::from_bits(bits.wrapping_add_signed(round(lacks))), sure & inside)
    }
}

/// How many bits a positive number has.
fn bits(x: u128) -> i32 {
    128 - x.leading_zeros() as i32
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Quotients of any size, exact ones, ties between two f64, and what lies beside them.
    #[test]
    fn a_sure_quotient_is_the_nearest() {
        let mut state = 1_u64;
        let mut random = |bits: u32| {
            state = state.wrapping_mul(0x5851_f42d_4c95_7f2d).wrapping_add(0x1405_7b7e_f767_814f);
            let (high, low) = (state >> 32, state.rotate_left(17) & 0xffff_ffff);
            (high << 32 | low) >> (64 - bits)
        };
        let (mut sure, mut all) = (0, 0);
        for i in 0..400_000_u32 {
            let den = random(1 + i % 60).max(1);
            // A quotient of 54 bits ends in a half of a unit; one of 53 and less is exact.
            let quotient = random(1 + i / 60 % 54);
            let near = u128::from(quotient) * u128::from(den);
            let near = u64::try_from(near).unwrap_or(u64::MAX);
            for num in [random(1 + i % 64), near, near.wrapping_add(1), near.wrapping_sub(1)] {
                let (nearest, is_sure) = Divisor::new(den).unwrap().divides(num);
                if num > 0 && is_sure {
                    let exact = Ratio { num: num.into(), den }.to_f64(0);
                    assert_eq!(nearest, exact, "{num} / {den}");
                    sure += 1;
                }
                all += 1;
            }
        }
        assert!(sure > all / 2, "{sure} of {all}");
        assert!(Divisor::new(1 << 60).is_none());
    }
}
