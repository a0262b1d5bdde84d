//! NEON registers, under the names that [`super`] uses. Every 64-bit ARM CPU has NEON.
//!
//! This file is compiled only if the target has NEON, so every CPU that runs it has the
//! instructions. This is the `SAFETY` argument for every call below. Loads and stores also stay
//! within an array of N elements and work with any alignment.
#![allow(unsafe_code, clippy::wildcard_imports)]

use core::arch::aarch64::*;

/// Whether [`singles::mul_add`] and [`doubles::mul_add`] round once.
pub(super) const FUSED: bool = true;

/// Defines the operations that f32 and f64 registers have in common.
macro_rules! float {
    (
        $scalar:ty, $n:literal, $reg:ty, $mask:ty,
        $dup:ident $load:ident $store:ident $add:ident $sub:ident $mul:ident $div:ident $neg:ident $fma:ident
        $min:ident $max:ident $abs:ident $sqrt:ident $lt:ident $le:ident $select:ident $and:ident $or:ident
        $xor:ident $to_bits:ident $from_bits:ident $to_signed:ident $below_zero:ident $dup_bits:ident
    ) => {
        pub(crate) type Reg = $reg;
        pub(crate) type Mask = $mask;
        pub(crate) type Scalar = $scalar;
        pub(crate) const N: usize = $n;

        #[inline(always)]
        pub(crate) fn splat(x: $scalar) -> Reg {
            cpu!($dup(x))
        }
        #[inline(always)]
        pub(crate) fn load(from: &[$scalar; N]) -> Reg {
            cpu!($load(from.as_ptr()))
        }
        #[inline(always)]
        pub(crate) fn store(x: Reg, to: &mut [$scalar; N]) {
            cpu!($store(to.as_mut_ptr(), x))
        }
        #[inline(always)]
        pub(crate) fn add(a: Reg, b: Reg) -> Reg {
            cpu!($add(a, b))
        }
        #[inline(always)]
        pub(crate) fn sub(a: Reg, b: Reg) -> Reg {
            cpu!($sub(a, b))
        }
        #[inline(always)]
        pub(crate) fn mul(a: Reg, b: Reg) -> Reg {
            cpu!($mul(a, b))
        }
        #[inline(always)]
        pub(crate) fn div(a: Reg, b: Reg) -> Reg {
            cpu!($div(a, b))
        }
        #[inline(always)]
        pub(crate) fn neg(a: Reg) -> Reg {
            cpu!($neg(a))
        }
        #[inline(always)]
        pub(crate) fn mul_add(a: Reg, b: Reg, c: Reg) -> Reg {
            // `vfma` takes the addend first.
            cpu!($fma(c, a, b))
        }
        #[inline(always)]
        pub(crate) fn min(a: Reg, b: Reg) -> Reg {
            cpu!($min(a, b))
        }
        #[inline(always)]
        pub(crate) fn max(a: Reg, b: Reg) -> Reg {
            cpu!($max(a, b))
        }
        #[inline(always)]
        pub(crate) fn abs(a: Reg) -> Reg {
            cpu!($abs(a))
        }
        #[inline(always)]
        pub(crate) fn sqrt(a: Reg) -> Reg {
            cpu!($sqrt(a))
        }
        #[inline(always)]
        pub(crate) fn power(a: Reg) -> Reg {
            // Infinity has only the exponent bits set, so this mask clears the sign and the
            // fraction and leaves a power of two.
            cpu!($from_bits($and($to_bits(a), $dup_bits(<$scalar>::INFINITY.to_bits()))))
        }
        #[inline(always)]
        pub(crate) fn flip(a: Reg, of: Reg) -> Reg {
            cpu!({
                // -0 has only the sign bit set. Toggling it works for zeros and NaN, unlike a
                // comparison.
                let sign = $and($to_bits(of), $dup_bits((-0.0 as $scalar).to_bits()));
                $from_bits($xor($to_bits(a), sign))
            })
        }
        #[inline(always)]
        pub(crate) fn or_sign(a: Reg, b: Reg) -> Reg {
            cpu!($from_bits($or($to_bits(a), $to_bits(b))))
        }
        #[inline(always)]
        pub(crate) fn negative(a: Reg) -> Mask {
            // Compare as integers, which are negative if the sign bit is set, even for -0 and NaN.
            cpu!($below_zero($to_signed(a)))
        }
        #[inline(always)]
        pub(crate) fn lt(a: Reg, b: Reg) -> Mask {
            cpu!($lt(a, b))
        }
        #[inline(always)]
        pub(crate) fn le(a: Reg, b: Reg) -> Mask {
            cpu!($le(a, b))
        }
        #[inline(always)]
        pub(crate) fn select(mask: Mask, yes: Reg, no: Reg) -> Reg {
            cpu!($select(mask, yes, no))
        }
        #[inline(always)]
        pub(crate) fn and(a: Mask, b: Mask) -> Mask {
            cpu!($and(a, b))
        }
        #[inline(always)]
        pub(crate) fn or(a: Mask, b: Mask) -> Mask {
            cpu!($or(a, b))
        }
    };
}

/// Operations on four f32 lanes.
pub(super) mod singles {
    use super::*;

    float!(f32, 4, float32x4_t, uint32x4_t,
        vdupq_n_f32 vld1q_f32 vst1q_f32 vaddq_f32 vsubq_f32 vmulq_f32 vdivq_f32 vnegq_f32 vfmaq_f32
        vminq_f32 vmaxq_f32 vabsq_f32 vsqrtq_f32 vcltq_f32 vcleq_f32 vbslq_f32 vandq_u32 vorrq_u32
        veorq_u32 vreinterpretq_u32_f32 vreinterpretq_f32_u32 vreinterpretq_s32_f32 vcltzq_s32
        vdupq_n_u32);

    #[inline(always)]
    pub(crate) fn not(a: Mask) -> Mask {
        cpu!(vmvnq_u32(a))
    }
    #[inline(always)]
    pub(crate) fn load_f32(from: &[f32; N]) -> Reg {
        load(from)
    }
    #[inline(always)]
    pub(crate) fn store_f32(x: Reg, to: &mut [f32; N]) {
        store(x, to);
    }
    #[inline(always)]
    pub(crate) fn any(mask: Mask) -> bool {
        cpu!(vmaxvq_u32(mask) != 0)
    }
    #[inline(always)]
    pub(crate) fn bits(mask: Mask) -> u32 {
        cpu!({
            // NEON has no instruction that converts a mask to an integer, so each lane keeps its
            // own bit and the lanes are summed.
            let lane = vld1q_u32([1, 2, 4, 8].as_ptr());
            vaddvq_u32(vandq_u32(mask, lane))
        })
    }
    /// Returns the bits of two masks at once, with each lane narrowed to 16 bits.
    #[inline(always)]
    pub(crate) fn bits_of_two(first: Mask, last: Mask) -> u32 {
        cpu!(bits_of_eight(vuzp1q_u16(vreinterpretq_u16_u32(first), vreinterpretq_u16_u32(last))))
    }
    /// Returns the bits of a mask with eight 16-bit lanes.
    #[inline(always)]
    pub(crate) fn bits_of_eight(mask: uint16x8_t) -> u32 {
        cpu!({
            let lane = vld1q_u16([1, 2, 4, 8, 16, 32, 64, 128].as_ptr());
            vaddvq_u16(vandq_u16(mask, lane)).into()
        })
    }
    #[inline(always)]
    pub(crate) fn from_bits(bits: u32) -> Mask {
        cpu!({
            let lane = vld1q_u32([1, 2, 4, 8].as_ptr());
            vtstq_u32(vdupq_n_u32(bits), lane)
        })
    }
    /// Transposes four rows of four values.
    #[inline(always)]
    pub(crate) fn transpose([a, b, c, d]: [Reg; 4]) -> [Reg; 4] {
        cpu!({
            // Interleave in two rounds: rows 0 with 2 and 1 with 3, then the results with each
            // other.
            let (ac, ac_high) = (vzip1q_f32(a, c), vzip2q_f32(a, c));
            let (bd, bd_high) = (vzip1q_f32(b, d), vzip2q_f32(b, d));
            [
                vzip1q_f32(ac, bd),
                vzip2q_f32(ac, bd),
                vzip1q_f32(ac_high, bd_high),
                vzip2q_f32(ac_high, bd_high),
            ]
        })
    }
    /// Permutes eight lanes by the lowest three bits of each byte of `order`. A byte lookup moves
    /// the four bytes of each lane.
    #[inline(always)]
    pub(crate) fn permute([a, b]: [Reg; 2], order: u64) -> [Reg; 2] {
        cpu!({
            // NEON's only shuffle with a variable order works on bytes, so lane i becomes bytes 4i
            // to 4i + 3.
            let lanes = vand_u8(vcreate_u8(order), vdup_n_u8(7));
            let first_byte = vshl_n_u8::<2>(lanes);
            let pairs =
                vzip1q_u8(vcombine_u8(first_byte, first_byte), vcombine_u8(first_byte, first_byte));
            let offsets = vreinterpretq_u8_u32(vdupq_n_u32(0x03_02_01_00));
            let bytes = |pairs| vaddq_u8(pairs, offsets);
            let table = uint8x16x2_t(vreinterpretq_u8_f32(a), vreinterpretq_u8_f32(b));
            let of = |pairs| vreinterpretq_f32_u8(vqtbl2q_u8(table, bytes(pairs)));
            [of(vzip1q_u8(pairs, pairs)), of(vzip2q_u8(pairs, pairs))]
        })
    }
    /// Returns the index of the smallest value among the lanes in the masks.
    #[inline(always)]
    pub(crate) fn lane_of_least([a, b]: [Reg; 2], [in_a, in_b]: [Mask; 2]) -> usize {
        cpu!({
            let (first, last) =
                (vld1q_u32([0, 1, 2, 3].as_ptr()), vld1q_u32([4, 5, 6, 7].as_ptr()));
            let high = vdupq_n_u32(!7);
            // Each key is the f32's bits with the lane number in place of the last three bits.
            // Positive floats sort like their bits, so one minimum finds both the value and its
            // lane. Lanes outside the mask become all ones, the largest key.
            let key =
                |x, lane, mask| vornq_u32(vbslq_u32(high, vreinterpretq_u32_f32(x), lane), mask);
            (vminvq_u32(vminq_u32(key(a, first, in_a), key(b, last, in_b))) & 7) as usize
        })
    }
}

/// Operations on two f64 lanes.
pub(super) mod doubles {
    use super::*;

    float!(f64, 2, float64x2_t, uint64x2_t,
        vdupq_n_f64 vld1q_f64 vst1q_f64 vaddq_f64 vsubq_f64 vmulq_f64 vdivq_f64 vnegq_f64 vfmaq_f64
        vminq_f64 vmaxq_f64 vabsq_f64 vsqrtq_f64 vcltq_f64 vcleq_f64 vbslq_f64 vandq_u64 vorrq_u64
        veorq_u64 vreinterpretq_u64_f64 vreinterpretq_f64_u64 vreinterpretq_s64_f64 vcltzq_s64
        vdupq_n_u64);

    #[inline(always)]
    pub(crate) fn not(a: Mask) -> Mask {
        // NEON has no 64-bit NOT, but the 32-bit NOT inverts the same bits.
        cpu!(vreinterpretq_u64_u32(vmvnq_u32(vreinterpretq_u32_u64(a))))
    }
    #[inline(always)]
    pub(crate) fn load_f32(from: &[f32; N]) -> Reg {
        cpu!(vcvt_f64_f32(vld1_f32(from.as_ptr())))
    }
    #[inline(always)]
    pub(crate) fn store_f32(x: Reg, to: &mut [f32; N]) {
        cpu!(vst1_f32(to.as_mut_ptr(), vcvt_f32_f64(x)))
    }
    #[inline(always)]
    pub(crate) fn any(mask: Mask) -> bool {
        cpu!(vmaxvq_u32(vreinterpretq_u32_u64(mask)) != 0)
    }
    #[inline(always)]
    pub(crate) fn bits(mask: Mask) -> u32 {
        cpu!({
            let lane = vld1q_u64([1, 2].as_ptr());
            vaddvq_u64(vandq_u64(mask, lane)) as u32
        })
    }
    /// Returns the bits of two masks at once, with each lane narrowed to 32 bits.
    #[inline(always)]
    pub(crate) fn bits_of_two(first: Mask, last: Mask) -> u32 {
        cpu!(singles::bits(vuzp1q_u32(vreinterpretq_u32_u64(first), vreinterpretq_u32_u64(last))))
    }
    #[inline(always)]
    pub(crate) fn from_bits(bits: u32) -> Mask {
        cpu!({
            let lane = vld1q_u64([1, 2].as_ptr());
            vtstq_u64(vdupq_n_u64(bits.into()), lane)
        })
    }
    /// Returns a register with the first lanes of `a` and `b`, and a register with their last
    /// lanes.
    #[inline(always)]
    pub(crate) fn zip(a: Reg, b: Reg) -> [Reg; 2] {
        cpu!([vzip1q_f64(a, b), vzip2q_f64(a, b)])
    }
    /// Returns the first lane of `a` and the last lane of `b`.
    #[inline(always)]
    pub(crate) fn ends(a: Reg, b: Reg) -> Reg {
        cpu!(vcopyq_laneq_f64::<1, 1>(a, b))
    }
    /// Copies the last lane to both lanes.
    #[inline(always)]
    pub(crate) fn last(a: Reg) -> Reg {
        cpu!(vdupq_laneq_f64::<1>(a))
    }
}

/// Operations on four i64 lanes, in two registers.
pub(super) mod integers {
    use super::*;

    pub(crate) type Regs = [int64x2_t; 2];

    #[inline(always)]
    pub(crate) fn splat(x: i64) -> Regs {
        cpu!([vdupq_n_s64(x), vdupq_n_s64(x)])
    }
    #[inline(always)]
    pub(crate) fn load(from: &[i64; 4]) -> Regs {
        cpu!([vld1q_s64(from.as_ptr()), vld1q_s64(from[2..].as_ptr())])
    }
    #[inline(always)]
    pub(crate) fn add(a: Regs, b: Regs) -> Regs {
        cpu!([vaddq_s64(a[0], b[0]), vaddq_s64(a[1], b[1])])
    }
    #[inline(always)]
    pub(crate) fn sub(a: Regs, b: Regs) -> Regs {
        cpu!([vsubq_s64(a[0], b[0]), vsubq_s64(a[1], b[1])])
    }
    /// Returns the low half of each lane.
    #[inline(always)]
    fn low(x: Regs) -> uint32x4_t {
        cpu!(vuzp1q_u32(vreinterpretq_u32_s64(x[0]), vreinterpretq_u32_s64(x[1])))
    }
    /// Returns the high half of each lane.
    #[inline(always)]
    fn high(x: Regs) -> uint32x4_t {
        cpu!(vuzp2q_u32(vreinterpretq_u32_s64(x[0]), vreinterpretq_u32_s64(x[1])))
    }
    /// Adds the products of the unsigned halves that reach the lower 64 bits.
    #[inline(always)]
    pub(crate) fn times(a: Regs, b: Regs) -> Regs {
        let (a_low, b_low) = (low(a), low(b));
        cpu!({
            let middle = vmlaq_u32(vmulq_u32(a_low, high(b)), high(a), b_low);
            let of = |half| vreinterpretq_s64_u32(half);
            let none = vdupq_n_u32(0);
            // Interleaving zeros below the products multiplies them by 2^32.
            let middle = [of(vzip1q_u32(none, middle)), of(vzip2q_u32(none, middle))];
            let of = |product| vreinterpretq_s64_u64(product);
            let lows = [
                of(vmull_u32(vget_low_u32(a_low), vget_low_u32(b_low))),
                of(vmull_high_u32(a_low, b_low)),
            ];
            add(lows, middle)
        })
    }
    #[inline(always)]
    pub(crate) fn negative(x: Regs) -> u32 {
        cpu!(singles::bits(vcltzq_s32(vreinterpretq_s32_u32(high(x)))))
    }
    #[inline(always)]
    pub(crate) fn zero(x: Regs) -> u32 {
        cpu!({
            let of = |mask| vreinterpretq_u32_u64(mask);
            singles::bits(vuzp1q_u32(of(vceqzq_s64(x[0])), of(vceqzq_s64(x[1]))))
        })
    }
}
