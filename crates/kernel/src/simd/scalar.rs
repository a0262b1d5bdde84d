//! Implements [`Lanes`] for f32 and f64 as single lanes, for code that resolves one pair at a time.

use super::lanes::{Lanes, Mask, mul_error};

impl Mask for bool {
    const N: usize = 1;

    #[inline(always)]
    fn bits(self) -> u32 {
        self as u32
    }
    #[inline(always)]
    fn from_bits(bits: u32) -> Self {
        bits & 1 != 0
    }
}

macro_rules! scalar {
    ($t:ty, $sqrt:expr) => {
        impl Lanes for $t {
            type Scalar = $t;
            type Mask = bool;
            const N: usize = 1;

            #[inline(always)]
            fn splat(x: $t) -> Self {
                x
            }
            #[inline(always)]
            fn load(from: &[$t]) -> Self {
                from[0]
            }
            #[inline(always)]
            fn load_f32(from: &[f32]) -> Self {
                from[0] as $t
            }
            #[inline(always)]
            fn store(self, to: &mut [$t]) {
                to[0] = self;
            }
            #[inline(always)]
            fn store_f32(self, to: &mut [f32]) {
                to[0] = self as f32;
            }
            #[inline(always)]
            fn mul_add(self, b: Self, c: Self) -> Self {
                self * b + c
            }
            #[inline(always)]
            fn mul_error(self, b: Self, product: Self) -> Self {
                // Multiplying by this factor splits a value into two halves. It is 2^h + 1, where h
                // is half the number of mantissa digits, rounded up.
                const SPLIT: $t = ((1 << <$t>::MANTISSA_DIGITS.div_ceil(2)) + 1) as $t;
                mul_error(self, b, product, SPLIT)
            }
            #[inline(always)]
            fn max(self, other: Self) -> Self {
                // Like the CPU's instruction, this returns the second operand if either is NaN.
                // `f32::max` would return the operand that is not NaN.
                if self > other { self } else { other }
            }
            #[inline(always)]
            fn min(self, other: Self) -> Self {
                if self < other { self } else { other }
            }
            #[inline(always)]
            fn abs(self) -> Self {
                <$t>::abs(self)
            }
            #[inline(always)]
            fn power(self) -> Self {
                Self::from_bits(self.to_bits() & Self::INFINITY.to_bits())
            }
            #[inline(always)]
            fn flip(self, of: Self) -> Self {
                // In WebAssembly, an `if` would compile to a branch.
                let sign = of.to_bits() & (-0.0 as $t).to_bits();
                Self::from_bits(self.to_bits() ^ sign)
            }
            #[inline(always)]
            fn or_sign(self, other: Self) -> Self {
                Self::from_bits(self.to_bits() | other.to_bits())
            }
            #[inline(always)]
            fn negative(self) -> bool {
                self.is_sign_negative()
            }
            #[inline(always)]
            fn sqrt(self) -> Self {
                $sqrt(self)
            }
            #[inline(always)]
            fn lt(self, other: Self) -> bool {
                self < other
            }
            #[inline(always)]
            fn le(self, other: Self) -> bool {
                self <= other
            }
            #[inline(always)]
            fn select(mask: bool, yes: Self, no: Self) -> Self {
                if mask { yes } else { no }
            }
        }
    };
}

// `core` has no square root; `wide` has one on every target.
scalar!(f32, |x| ::wide::f32x4::splat(x).sqrt().to_array()[0]);
scalar!(f64, |x| ::wide::f64x2::splat(x).sqrt().to_array()[0]);
