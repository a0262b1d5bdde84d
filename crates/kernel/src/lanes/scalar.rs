//! One lane: plain numbers, for replays, tails and the level without vector registers.

use super::int::One;
use super::{Lanes, Level, Mask, Pair, Simd, mul_error};

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
                // Two to half of the digits, rounded up, and one.
                const SPLIT: $t = ((1 << <$t>::MANTISSA_DIGITS.div_ceil(2)) + 1) as $t;
                mul_error(self, b, product, SPLIT)
            }
            #[inline(always)]
            fn max(self, other: Self) -> Self {
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
                if of.is_sign_negative() { -self } else { self }
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

/// The level without vector registers.
#[derive(Clone, Copy)]
pub(super) struct Scalar;

type Two<T> = Pair<T>;
type Four<T> = Pair<Two<T>>;
type Eight<T> = Pair<Four<T>>;

impl Simd for Scalar {
    type F32x4 = Four<f32>;
    type F32x8 = Eight<f32>;
    type F32x16 = Pair<Eight<f32>>;
    type F64x4 = Four<f64>;
    type F64x8 = Eight<f64>;
    type I64x4 = Four<One>;
    type I64x8 = Eight<One>;
    const LEVEL: Level = Level::SCALAR;
}
