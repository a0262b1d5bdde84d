//! Combines two sets of lanes into one, for more lanes than fit in one register.

use core::ops::{Add, BitAnd, BitOr, Div, Mul, Neg, Not, Sub};

use super::lanes::{Lanes, Mask};

/// The lanes of the first half, followed by the lanes of the second half. This type also serves as
/// the mask of such lanes.
#[derive(Clone, Copy)]
pub struct Pair<L>(pub(super) L, pub(super) L);

macro_rules! both {
    ($($op:ident $f:ident),*) => {$(
        impl<L: $op<Output = L>> $op for Pair<L> {
            type Output = Self;
            #[inline(always)]
            fn $f(self, b: Self) -> Self {
                Self(self.0.$f(b.0), self.1.$f(b.1))
            }
        }
    )*};
}
both!(Add add, Sub sub, Mul mul, Div div, BitAnd bitand, BitOr bitor);

impl<L: Neg<Output = L>> Neg for Pair<L> {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        Self(-self.0, -self.1)
    }
}

impl<M: Not<Output = M>> Not for Pair<M> {
    type Output = Self;
    #[inline(always)]
    fn not(self) -> Self {
        Self(!self.0, !self.1)
    }
}

impl<M: Mask> Mask for Pair<M> {
    const N: usize = 2 * M::N;

    #[inline(always)]
    fn bits(self) -> u32 {
        self.0.bits_of_two(self.1)
    }
    #[inline(always)]
    fn from_bits(bits: u32) -> Self {
        Self(M::from_bits(bits), M::from_bits(bits >> M::N))
    }
    #[inline(always)]
    fn any(self) -> bool {
        (self.0 | self.1).any()
    }
}

impl<L: Lanes> Lanes for Pair<L> {
    type Scalar = L::Scalar;
    type Mask = Pair<L::Mask>;
    const N: usize = 2 * L::N;

    #[inline(always)]
    fn splat(x: L::Scalar) -> Self {
        Self(L::splat(x), L::splat(x))
    }
    #[inline(always)]
    fn load(from: &[L::Scalar]) -> Self {
        Self(L::load(from), L::load(&from[L::N..]))
    }
    #[inline(always)]
    fn load_f32(from: &[f32]) -> Self {
        Self(L::load_f32(from), L::load_f32(&from[L::N..]))
    }
    #[inline(always)]
    fn store(self, to: &mut [L::Scalar]) {
        self.0.store(to);
        self.1.store(&mut to[L::N..]);
    }
    #[inline(always)]
    fn store_f32(self, to: &mut [f32]) {
        self.0.store_f32(to);
        self.1.store_f32(&mut to[L::N..]);
    }
    #[inline(always)]
    fn mul_add(self, b: Self, c: Self) -> Self {
        Self(self.0.mul_add(b.0, c.0), self.1.mul_add(b.1, c.1))
    }
    #[inline(always)]
    fn mul_error(self, b: Self, product: Self) -> Self {
        Self(self.0.mul_error(b.0, product.0), self.1.mul_error(b.1, product.1))
    }
    #[inline(always)]
    fn max(self, other: Self) -> Self {
        Self(self.0.max(other.0), self.1.max(other.1))
    }
    #[inline(always)]
    fn min(self, other: Self) -> Self {
        Self(self.0.min(other.0), self.1.min(other.1))
    }
    #[inline(always)]
    fn abs(self) -> Self {
        Self(self.0.abs(), self.1.abs())
    }
    #[inline(always)]
    fn power(self) -> Self {
        Self(self.0.power(), self.1.power())
    }
    #[inline(always)]
    fn flip(self, of: Self) -> Self {
        Self(self.0.flip(of.0), self.1.flip(of.1))
    }
    #[inline(always)]
    fn or_sign(self, other: Self) -> Self {
        Self(self.0.or_sign(other.0), self.1.or_sign(other.1))
    }
    #[inline(always)]
    fn negative(self) -> Self::Mask {
        Pair(self.0.negative(), self.1.negative())
    }
    #[inline(always)]
    fn sqrt(self) -> Self {
        Self(self.0.sqrt(), self.1.sqrt())
    }
    #[inline(always)]
    fn lt(self, other: Self) -> Self::Mask {
        Pair(self.0.lt(other.0), self.1.lt(other.1))
    }
    #[inline(always)]
    fn le(self, other: Self) -> Self::Mask {
        Pair(self.0.le(other.0), self.1.le(other.1))
    }
    #[inline(always)]
    fn select(mask: Self::Mask, yes: Self, no: Self) -> Self {
        Self(L::select(mask.0, yes.0, no.0), L::select(mask.1, yes.1, no.1))
    }
}
