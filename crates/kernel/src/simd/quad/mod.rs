//! The level with 128-bit registers: NEON and WebAssembly's simd128.
//!
//! This level has instructions for operations that the `wide` crate performs lane by lane:
//! conversions, masks from bits, permutations, and integer products. Wider lanes are pairs of
//! registers. `neon` and `wasm` provide the instructions under common names; everything else is
//! shared and defined here.

#[cfg(target_arch = "aarch64")]
#[path = "neon.rs"]
mod cpu;
#[cfg(target_arch = "wasm32")]
#[path = "wasm.rs"]
mod cpu;

use core::ops::{Add, BitAnd, BitOr, Div, Mul, Neg, Not, Sub};

use super::int::{Ints, shifted};
use super::lanes::{Lanes, Mask, mul_error};
use super::level::Level;
use super::level_lanes::Simd;
use super::pair::Pair;

/// Implements the lanes of an f32 or f64 register, and its mask.
macro_rules! lanes {
    ($name:ident, $mask:ident, $cpu:ident) => {
        #[derive(Clone, Copy)]
        pub(super) struct $name(cpu::$cpu::Reg);

        /// A mask. In each lane, either all bits are set or none are.
        #[derive(Clone, Copy)]
        pub(super) struct $mask(cpu::$cpu::Mask);

        impl Add for $name {
            type Output = Self;
            #[inline(always)]
            fn add(self, b: Self) -> Self {
                Self(cpu::$cpu::add(self.0, b.0))
            }
        }
        impl Sub for $name {
            type Output = Self;
            #[inline(always)]
            fn sub(self, b: Self) -> Self {
                Self(cpu::$cpu::sub(self.0, b.0))
            }
        }
        impl Mul for $name {
            type Output = Self;
            #[inline(always)]
            fn mul(self, b: Self) -> Self {
                Self(cpu::$cpu::mul(self.0, b.0))
            }
        }
        impl Div for $name {
            type Output = Self;
            #[inline(always)]
            fn div(self, b: Self) -> Self {
                Self(cpu::$cpu::div(self.0, b.0))
            }
        }
        impl Neg for $name {
            type Output = Self;
            #[inline(always)]
            fn neg(self) -> Self {
                Self(cpu::$cpu::neg(self.0))
            }
        }
        impl BitAnd for $mask {
            type Output = Self;
            #[inline(always)]
            fn bitand(self, b: Self) -> Self {
                Self(cpu::$cpu::and(self.0, b.0))
            }
        }
        impl BitOr for $mask {
            type Output = Self;
            #[inline(always)]
            fn bitor(self, b: Self) -> Self {
                Self(cpu::$cpu::or(self.0, b.0))
            }
        }
        impl Not for $mask {
            type Output = Self;
            #[inline(always)]
            fn not(self) -> Self {
                Self(cpu::$cpu::not(self.0))
            }
        }

        impl Mask for $mask {
            const N: usize = cpu::$cpu::N;

            #[inline(always)]
            fn bits(self) -> u32 {
                cpu::$cpu::bits(self.0)
            }
            #[inline(always)]
            fn bits_of_two(self, last: Self) -> u32 {
                cpu::$cpu::bits_of_two(self.0, last.0)
            }
            #[inline(always)]
            fn from_bits(bits: u32) -> Self {
                Self(cpu::$cpu::from_bits(bits))
            }
            #[inline(always)]
            fn any(self) -> bool {
                cpu::$cpu::any(self.0)
            }
        }

        impl Lanes for $name {
            type Scalar = cpu::$cpu::Scalar;
            type Mask = $mask;
            const N: usize = cpu::$cpu::N;

            #[inline(always)]
            fn splat(x: Self::Scalar) -> Self {
                Self(cpu::$cpu::splat(x))
            }
            #[inline(always)]
            fn load(from: &[Self::Scalar]) -> Self {
                Self(cpu::$cpu::load(from.first_chunk().expect("the slice has N elements")))
            }
            #[inline(always)]
            fn load_f32(from: &[f32]) -> Self {
                Self(cpu::$cpu::load_f32(from.first_chunk().expect("the slice has N elements")))
            }
            #[inline(always)]
            fn store(self, to: &mut [Self::Scalar]) {
                cpu::$cpu::store(self.0, to.first_chunk_mut().expect("the slice has N elements"));
            }
            #[inline(always)]
            fn store_f32(self, to: &mut [f32]) {
                cpu::$cpu::store_f32(
                    self.0,
                    to.first_chunk_mut().expect("the slice has N elements"),
                );
            }
            #[inline(always)]
            fn mul_add(self, b: Self, c: Self) -> Self {
                Self(cpu::$cpu::mul_add(self.0, b.0, c.0))
            }
            #[inline(always)]
            fn mul_error(self, b: Self, product: Self) -> Self {
                if cpu::FUSED {
                    // A fused multiply-add rounds once, and the error of a product is representable
                    // in the same format, so this is exact.
                    return self.mul_add(b, -product);
                }
                // The split factor is two to the power of half the digits (rounded up), plus one.
                const HALF: u32 = <cpu::$cpu::Scalar>::MANTISSA_DIGITS.div_ceil(2);
                // WebAssembly has no fused operations, so split the factors into halves whose
                // products are exact (Dekker).
                mul_error(self, b, product, Self::splat(((1 << HALF) + 1) as Self::Scalar))
            }
            #[inline(always)]
            fn max(self, other: Self) -> Self {
                Self(cpu::$cpu::max(self.0, other.0))
            }
            #[inline(always)]
            fn min(self, other: Self) -> Self {
                Self(cpu::$cpu::min(self.0, other.0))
            }
            #[inline(always)]
            fn abs(self) -> Self {
                Self(cpu::$cpu::abs(self.0))
            }
            #[inline(always)]
            fn power(self) -> Self {
                Self(cpu::$cpu::power(self.0))
            }
            #[inline(always)]
            fn flip(self, of: Self) -> Self {
                Self(cpu::$cpu::flip(self.0, of.0))
            }
            #[inline(always)]
            fn or_sign(self, other: Self) -> Self {
                Self(cpu::$cpu::or_sign(self.0, other.0))
            }
            #[inline(always)]
            fn negative(self) -> $mask {
                $mask(cpu::$cpu::negative(self.0))
            }
            #[inline(always)]
            fn sqrt(self) -> Self {
                Self(cpu::$cpu::sqrt(self.0))
            }
            #[inline(always)]
            fn lt(self, other: Self) -> $mask {
                $mask(cpu::$cpu::lt(self.0, other.0))
            }
            #[inline(always)]
            fn le(self, other: Self) -> $mask {
                $mask(cpu::$cpu::le(self.0, other.0))
            }
            #[inline(always)]
            fn select(mask: $mask, yes: Self, no: Self) -> Self {
                Self(cpu::$cpu::select(mask.0, yes.0, no.0))
            }
        }
    };
}
lanes!(Singles, SinglesMask, singles);
lanes!(Doubles, DoublesMask, doubles);

/// Two registers of i64 lanes. Together, they have as many lanes as one register of u32 lanes,
/// because products are made of 32-bit ones.
#[derive(Clone, Copy)]
pub(super) struct Integers(cpu::integers::Regs);

impl Add for Integers {
    type Output = Self;
    #[inline(always)]
    fn add(self, b: Self) -> Self {
        Self(cpu::integers::add(self.0, b.0))
    }
}

impl Sub for Integers {
    type Output = Self;
    #[inline(always)]
    fn sub(self, b: Self) -> Self {
        Self(cpu::integers::sub(self.0, b.0))
    }
}

impl Ints for Integers {
    const N: usize = 4;
    const BITS: u32 = 64;

    #[inline(always)]
    fn splat(x: i64) -> Self {
        Self(cpu::integers::splat(x))
    }
    #[inline(always)]
    fn load(from: &[i64]) -> Self {
        Self(cpu::integers::load(from.first_chunk().expect("the slice has N elements")))
    }
    #[inline(always)]
    fn shifted(from: &[i64], exponents: &[i64]) -> Self {
        Self::load(&shifted::<4>(from, exponents))
    }
    #[inline(always)]
    fn times(self, b: Self) -> Self {
        Self(cpu::integers::times(self.0, b.0))
    }
    #[inline(always)]
    fn negative(self) -> u32 {
        cpu::integers::negative(self.0)
    }
    #[inline(always)]
    fn zero(self) -> u32 {
        cpu::integers::zero(self.0)
    }
}

/// The level: 128-bit registers, and pairs of them for more lanes.
#[derive(Clone, Copy)]
pub(super) struct Baseline;

impl Simd for Baseline {
    type F32x4 = Singles;
    type F32x8 = Pair<Singles>;
    type F32x16 = Pair<Pair<Singles>>;
    type F64x4 = Pair<Doubles>;
    type F64x8 = Pair<Pair<Doubles>>;
    type I64x8 = Pair<Integers>;
    type WideInts = Self::I64x8;
    // A 128-bit register holds four f32 values but only two f64 values. `F64s` is a pair, so both
    // types have one lane for each of four triangles.
    type F32s = Self::F32x4;
    type F64s = Self::F64x4;
    const LEVEL: Level = Level::PORTABLE;

    #[inline(always)]
    fn permute(Pair(a, b): Self::F32x8, order: u64) -> Self::F32x8 {
        // A lane may come from either register, so the halves cannot be permuted separately as in
        // `Pair`.
        let [a, b] = cpu::singles::permute([a.0, b.0], order);
        Pair(Singles(a), Singles(b))
    }
    #[inline(always)]
    fn lane_of_least(
        Pair(a, b): Self::F32x8,
        Pair(in_a, in_b): <Self::F32x8 as Lanes>::Mask,
    ) -> usize {
        cpu::singles::lane_of_least([a.0, b.0], [in_a.0, in_b.0])
    }
    #[inline(always)]
    fn transpose([a, b, c, d]: [Self::F32x4; 4]) -> [Self::F32x4; 4] {
        let [a, b, c, d] = cpu::singles::transpose([a.0, b.0, c.0, d.0]);
        [Singles(a), Singles(b), Singles(c), Singles(d)]
    }
    #[inline(always)]
    fn columns<'a>(row: impl Fn(usize) -> &'a [f32; 4]) -> [Self::F32x16; 4] {
        let load = |i: usize| Singles::load(row(i));
        let four = |i: usize| Self::transpose([load(i), load(i + 1), load(i + 2), load(i + 3)]);
        // Use four 4×4 transpositions. Column k of the result joins column k of all four.
        let ([a, b, c, d], [e, f, g, h]) = (four(0), four(4));
        let ([i, j, k, l], [m, n, o, p]) = (four(8), four(12));
        [
            Pair(Pair(a, e), Pair(i, m)),
            Pair(Pair(b, f), Pair(j, n)),
            Pair(Pair(c, g), Pair(k, o)),
            Pair(Pair(d, h), Pair(l, p)),
        ]
    }
    #[inline(always)]
    fn register_columns<'a>(row: impl Fn(usize) -> &'a [f32; 4]) -> [Singles; 4] {
        let load = |i: usize| Singles::load(row(i));
        Self::transpose([load(0), load(1), load(2), load(3)])
    }
    #[inline(always)]
    fn halves(first: &[f32; 8], last: &[f32; 8]) -> Self::F32x16 {
        Pair(Lanes::load(first), Lanes::load(last))
    }
    #[inline(always)]
    fn transpose_f64([a, b, c, d]: [Self::F64x4; 4]) -> [Self::F64x4; 4] {
        // Use four two-lane registers: `zip` transposes 2×2 blocks, which are then arranged.
        let zip = |x: Doubles, y: Doubles| cpu::doubles::zip(x.0, y.0).map(Doubles);
        let ([a0, a1], [a2, a3]) = (zip(a.0, b.0), zip(a.1, b.1));
        let ([c0, c1], [c2, c3]) = (zip(c.0, d.0), zip(c.1, d.1));
        [Pair(a0, c0), Pair(a1, c1), Pair(a2, c2), Pair(a3, c3)]
    }
    #[inline(always)]
    fn first_and_last(Pair(a, b): Self::F64x4) -> Self::F64x4 {
        Pair(Doubles(cpu::doubles::ends(a.0, b.0)), Doubles(cpu::doubles::last(b.0)))
    }
}
