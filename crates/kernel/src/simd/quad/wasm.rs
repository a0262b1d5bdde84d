//! WebAssembly simd128 registers, under the names that [`super`] uses.
//!
//! The build target has these instructions, so their intrinsics are safe to call, and `SAFETY`
//! comments concern only memory. Multiply-adds are not fused: relaxed SIMD could fuse them, but not
//! every browser supports it.
#![allow(clippy::wildcard_imports)]

use core::arch::wasm32::*;

/// Whether [`singles::mul_add`] and [`doubles::mul_add`] round once.
pub(super) const FUSED: bool = false;

/// Defines the operations that f32 and f64 registers have in common.
macro_rules! float {
    (
        $scalar:ty, $n:literal,
        $splat:ident $add:ident $sub:ident $mul:ident $div:ident $neg:ident $pmin:ident $pmax:ident $abs:ident
        $sqrt:ident $lt:ident $le:ident $bitmask:ident $below:ident
    ) => {
        pub(crate) type Reg = v128;
        pub(crate) type Mask = v128;
        pub(crate) type Scalar = $scalar;
        pub(crate) const N: usize = $n;

        #[inline(always)]
        pub(crate) fn splat(x: $scalar) -> Reg {
            $splat(x)
        }
        #[allow(unsafe_code)]
        #[inline(always)]
        pub(crate) fn load(from: &[$scalar; N]) -> Reg {
            // SAFETY: the load reads the 128 bits of the array, with any alignment.
            unsafe { v128_load(from.as_ptr().cast()) }
        }
        #[allow(unsafe_code)]
        #[inline(always)]
        pub(crate) fn store(x: Reg, to: &mut [$scalar; N]) {
            // SAFETY: the store writes the 128 bits of the array, with any alignment.
            unsafe { v128_store(to.as_mut_ptr().cast(), x) }
        }
        #[inline(always)]
        pub(crate) fn add(a: Reg, b: Reg) -> Reg {
            $add(a, b)
        }
        #[inline(always)]
        pub(crate) fn sub(a: Reg, b: Reg) -> Reg {
            $sub(a, b)
        }
        #[inline(always)]
        pub(crate) fn mul(a: Reg, b: Reg) -> Reg {
            $mul(a, b)
        }
        #[inline(always)]
        pub(crate) fn div(a: Reg, b: Reg) -> Reg {
            $div(a, b)
        }
        #[inline(always)]
        pub(crate) fn neg(a: Reg) -> Reg {
            $neg(a)
        }
        #[inline(always)]
        pub(crate) fn mul_add(a: Reg, b: Reg, c: Reg) -> Reg {
            $add($mul(a, b), c)
        }
        /// Uses the CPU's own minimum, which does not follow the IEEE rules for NaN.
        #[inline(always)]
        pub(crate) fn min(a: Reg, b: Reg) -> Reg {
            $pmin(a, b)
        }
        #[inline(always)]
        pub(crate) fn max(a: Reg, b: Reg) -> Reg {
            $pmax(a, b)
        }
        #[inline(always)]
        pub(crate) fn abs(a: Reg) -> Reg {
            $abs(a)
        }
        #[inline(always)]
        pub(crate) fn sqrt(a: Reg) -> Reg {
            $sqrt(a)
        }
        #[inline(always)]
        pub(crate) fn power(a: Reg) -> Reg {
            // Infinity has only the exponent bits set, so this mask clears the sign and the
            // fraction and leaves a power of two.
            v128_and(a, $splat(<$scalar>::INFINITY))
        }
        #[inline(always)]
        pub(crate) fn flip(a: Reg, of: Reg) -> Reg {
            v128_xor(a, v128_and(of, $splat(-0.0)))
        }
        #[inline(always)]
        pub(crate) fn or_sign(a: Reg, b: Reg) -> Reg {
            v128_or(a, b)
        }
        #[inline(always)]
        pub(crate) fn negative(a: Reg) -> Mask {
            // Compare as integers, which are negative if the sign bit is set, even for -0 and NaN.
            $below(a, u64x2_splat(0))
        }
        #[inline(always)]
        pub(crate) fn lt(a: Reg, b: Reg) -> Mask {
            $lt(a, b)
        }
        #[inline(always)]
        pub(crate) fn le(a: Reg, b: Reg) -> Mask {
            $le(a, b)
        }
        #[inline(always)]
        pub(crate) fn select(mask: Mask, yes: Reg, no: Reg) -> Reg {
            v128_bitselect(yes, no, mask)
        }
        #[inline(always)]
        pub(crate) fn and(a: Mask, b: Mask) -> Mask {
            v128_and(a, b)
        }
        #[inline(always)]
        pub(crate) fn or(a: Mask, b: Mask) -> Mask {
            v128_or(a, b)
        }
        #[inline(always)]
        pub(crate) fn not(a: Mask) -> Mask {
            v128_not(a)
        }
        #[inline(always)]
        pub(crate) fn any(mask: Mask) -> bool {
            v128_any_true(mask)
        }
        #[inline(always)]
        pub(crate) fn bits(mask: Mask) -> u32 {
            $bitmask(mask).into()
        }
        #[inline(always)]
        pub(crate) fn bits_of_two(first: Mask, last: Mask) -> u32 {
            bits(first) | bits(last) << N
        }
    };
}

/// Operations on four f32 lanes.
pub(super) mod singles {
    use super::*;

    float!(f32, 4,
        f32x4_splat f32x4_add f32x4_sub f32x4_mul f32x4_div f32x4_neg f32x4_pmin f32x4_pmax f32x4_abs
        f32x4_sqrt f32x4_lt f32x4_le u32x4_bitmask i32x4_lt);

    #[inline(always)]
    pub(crate) fn load_f32(from: &[f32; N]) -> Reg {
        load(from)
    }
    #[inline(always)]
    pub(crate) fn store_f32(x: Reg, to: &mut [f32; N]) {
        store(x, to);
    }
    #[inline(always)]
    pub(crate) fn from_bits(bits: u32) -> Mask {
        let lane = u32x4(1, 2, 4, 8);
        u32x4_eq(v128_and(u32x4_splat(bits), lane), lane)
    }
    /// Transposes four rows of four values.
    #[inline(always)]
    pub(crate) fn transpose([a, b, c, d]: [Reg; 4]) -> [Reg; 4] {
        let low = |a, b| u32x4_shuffle::<0, 4, 1, 5>(a, b);
        let high = |a, b| u32x4_shuffle::<2, 6, 3, 7>(a, b);
        let (ac, ac_high, bd, bd_high) = (low(a, c), high(a, c), low(b, d), high(b, d));
        [low(ac, bd), high(ac, bd), low(ac_high, bd_high), high(ac_high, bd_high)]
    }
    /// Permutes eight lanes by the lowest three bits of each byte of `order`. Each byte is looked
    /// up in both halves; a lookup yields 0 for an index outside its half.
    #[inline(always)]
    pub(crate) fn permute([a, b]: [Reg; 2], order: u64) -> [Reg; 2] {
        let lanes = v128_and(u64x2_splat(order), u8x16_splat(7));
        let first_byte = u8x16_shl(lanes, 2);
        let offsets = u32x4_splat(0x03_02_01_00);
        let of = |places| {
            let places = u8x16_add(places, offsets);
            // `swizzle` returns 0 for an index beyond its register, so each half yields the bytes
            // that it holds, and an OR combines them.
            let other = u8x16_sub(places, u8x16_splat(16));
            v128_or(u8x16_swizzle(a, places), u8x16_swizzle(b, other))
        };
        [
            of(u8x16_shuffle::<0, 0, 0, 0, 1, 1, 1, 1, 2, 2, 2, 2, 3, 3, 3, 3>(
                first_byte, first_byte,
            )),
            of(u8x16_shuffle::<4, 4, 4, 4, 5, 5, 5, 5, 6, 6, 6, 6, 7, 7, 7, 7>(
                first_byte, first_byte,
            )),
        ]
    }
    /// Returns the index of the smallest value among the lanes in the masks.
    #[inline(always)]
    pub(crate) fn lane_of_least([a, b]: [Reg; 2], [in_a, in_b]: [Mask; 2]) -> usize {
        let high = u32x4_splat(!7);
        // As in `neon`, each key is the f32's bits with the lane number in place of the last three
        // bits, or all ones outside the mask.
        let key = |x, lane, mask| v128_or(v128_or(v128_and(x, high), lane), v128_not(mask));
        let (first, last) = (u32x4(0, 1, 2, 3), u32x4(4, 5, 6, 7));
        let four = u32x4_min(key(a, first, in_a), key(b, last, in_b));
        let two = u32x4_min(four, u32x4_shuffle::<2, 3, 0, 1>(four, four));
        let one = u32x4_min(two, u32x4_shuffle::<1, 0, 3, 2>(two, two));
        (u32x4_extract_lane::<0>(one) & 7) as usize
    }
}

/// Operations on two f64 lanes.
pub(super) mod doubles {
    use super::*;

    float!(f64, 2,
        f64x2_splat f64x2_add f64x2_sub f64x2_mul f64x2_div f64x2_neg f64x2_pmin f64x2_pmax f64x2_abs
        f64x2_sqrt f64x2_lt f64x2_le u64x2_bitmask i64x2_lt);

    #[allow(unsafe_code)]
    #[inline(always)]
    pub(crate) fn load_f32(from: &[f32; N]) -> Reg {
        // SAFETY: the load reads the 64 bits of the array, with any alignment.
        f64x2_promote_low_f32x4(unsafe { v128_load64_zero(from.as_ptr().cast()) })
    }
    #[allow(unsafe_code)]
    #[inline(always)]
    pub(crate) fn store_f32(x: Reg, to: &mut [f32; N]) {
        // SAFETY: the store writes the 64 bits of the array, with any alignment.
        unsafe { v128_store64_lane::<0>(f32x4_demote_f64x2_zero(x), to.as_mut_ptr().cast()) }
    }
    #[inline(always)]
    pub(crate) fn from_bits(bits: u32) -> Mask {
        let lane = u64x2(1, 2);
        u64x2_eq(v128_and(u64x2_splat(bits.into()), lane), lane)
    }
    /// Returns a register with the first lanes of `a` and `b`, and a register with their last
    /// lanes.
    #[inline(always)]
    pub(crate) fn zip(a: Reg, b: Reg) -> [Reg; 2] {
        [u64x2_shuffle::<0, 2>(a, b), u64x2_shuffle::<1, 3>(a, b)]
    }
    /// Returns the first lane of `a` and the last lane of `b`.
    #[inline(always)]
    pub(crate) fn ends(a: Reg, b: Reg) -> Reg {
        u64x2_shuffle::<0, 3>(a, b)
    }
    /// Copies the last lane to both lanes.
    #[inline(always)]
    pub(crate) fn last(a: Reg) -> Reg {
        u64x2_shuffle::<1, 1>(a, a)
    }
}

/// Operations on four i64 lanes, in two registers.
pub(super) mod integers {
    use super::*;

    pub(crate) type Regs = [v128; 2];

    #[inline(always)]
    pub(crate) fn splat(x: i64) -> Regs {
        [i64x2_splat(x), i64x2_splat(x)]
    }
    #[allow(unsafe_code)]
    #[inline(always)]
    pub(crate) fn load(from: &[i64; 4]) -> Regs {
        // SAFETY: each load reads 128 bits of the array, with any alignment.
        unsafe { [v128_load(from.as_ptr().cast()), v128_load(from[2..].as_ptr().cast())] }
    }
    #[inline(always)]
    pub(crate) fn add(a: Regs, b: Regs) -> Regs {
        [i64x2_add(a[0], b[0]), i64x2_add(a[1], b[1])]
    }
    #[inline(always)]
    pub(crate) fn sub(a: Regs, b: Regs) -> Regs {
        [i64x2_sub(a[0], b[0]), i64x2_sub(a[1], b[1])]
    }
    /// Returns the low half of each lane.
    #[inline(always)]
    fn low(x: Regs) -> v128 {
        i32x4_shuffle::<0, 2, 4, 6>(x[0], x[1])
    }
    /// Returns the high half of each lane.
    #[inline(always)]
    fn high(x: Regs) -> v128 {
        i32x4_shuffle::<1, 3, 5, 7>(x[0], x[1])
    }
    /// Adds the products of the unsigned halves that reach the lower 64 bits.
    #[inline(always)]
    pub(crate) fn times(a: Regs, b: Regs) -> Regs {
        let (a_low, b_low) = (low(a), low(b));
        let middle = i32x4_add(i32x4_mul(a_low, high(b)), i32x4_mul(high(a), b_low));
        let none = i64x2_splat(0);
        // Interleaving zeros below the products multiplies them by 2^32.
        let middle =
            [i32x4_shuffle::<0, 4, 1, 5>(none, middle), i32x4_shuffle::<0, 6, 1, 7>(none, middle)];
        let lows = [i64x2_extmul_low_u32x4(a_low, b_low), i64x2_extmul_high_u32x4(a_low, b_low)];
        add(lows, middle)
    }
    #[inline(always)]
    pub(crate) fn negative(x: Regs) -> u32 {
        i32x4_bitmask(high(x)).into()
    }
    #[inline(always)]
    pub(crate) fn zero(x: Regs) -> u32 {
        let none = i64x2_splat(0);
        negative([i64x2_eq(x[0], none), i64x2_eq(x[1], none)])
    }
}
