//! Numbers that record, to first order, by how much each rounding may have changed them. Tests use
//! them to find the worst case of rounding.
//!
//! ```text
//!   x + y  =  value  ±  share₁  ±  share₂  …  ±  shareₙ      one share per earlier rounding and
//!                                            ±  u|value|     per copied input, plus the sum's own
//! ```
//!
//! The filter's code runs on these numbers unchanged. No known input makes all roundings err in the
//! same direction, but the bounds are derived to cover even that case. Products and sums are
//! rounded separately, as on a level without fused operations.
//!
//! Rump and Kashiwagi, *Implementation and improvements of affine arithmetic*, 2015, describe the
//! general method.

use core::cell::{Cell, RefCell};
use core::ops::{Add, Div, Mul, Neg, Sub};
use std::collections::VecDeque;
use std::thread_local;

use super::bound;
use crate::simd::{Ints, Lanes, Level, Simd, Vec3};

/// The maximum number of roundings in a case.
const SHARES: usize = 320;

thread_local! {
    /// The number of roundings so far.
    static USED: Cell<usize> = const { Cell::new(0) };
    /// The errors of the numbers that are loaded next.
    static LOADED: RefCell<VecDeque<f64>> = const { RefCell::new(VecDeque::new()) };
}

/// A number, and the amount by which each rounding may have changed it.
#[derive(Clone, Copy)]
pub(super) struct Worst {
    pub(super) value: f64,
    shares: [f64; SHARES],
}

impl Worst {
    /// Returns a number without an error.
    fn exact(value: f64) -> Self {
        Self { value, shares: [0.0; SHARES] }
    }

    /// Returns a number with an error of at most `share`.
    pub(super) fn off_by(value: f64, share: f64) -> Self {
        let number = USED.get();
        USED.set(number + 1);
        let mut all = Self::exact(value);
        // Each rounding has its own element of `shares`. If a rounding enters a result twice with
        // opposite signs, its shares cancel.
        all.shares[number] = share;
        all
    }

    /// Returns the rounded copy of a number.
    pub(super) fn copy(value: f64) -> Self {
        Self::off_by(value, f64::from(bound::U) * value.abs())
    }

    /// Returns the rounded copy of a vector.
    pub(super) fn copies(v: [f64; 3]) -> Vec3<Self> {
        let [x, y, z] = v.map(Self::copy);
        Vec3 { x, y, z }
    }

    /// Returns the number after one more rounding.
    pub(super) fn rounded(self) -> Self {
        let mut rounded = Self::copy(self.value);
        for (to, from) in rounded.shares.iter_mut().zip(self.shares) {
            *to += from;
        }
        rounded
    }

    /// Returns the product without rounding.
    pub(super) fn times(&self, b: &Self) -> Self {
        // To first order, d(ab) = b da + a db. The product of two shares is of second order and is
        // omitted.
        Self::combined(self.value * b.value, (self, b.value), (b, self.value))
    }

    /// Returns the sum without rounding.
    pub(super) fn plus(&self, b: &Self) -> Self {
        Self::combined(self.value + b.value, (self, 1.0), (b, 1.0))
    }

    /// Returns the quotient without rounding.
    pub(super) fn over(&self, b: Self) -> Self {
        let q = self.value / b.value;
        // To first order, d(a/b) = da/b - (a/b) db/b.
        Self::combined(q, (self, 1.0 / b.value), (&b, -q / b.value))
    }

    /// Returns the largest possible error.
    pub(super) fn most(&self) -> f64 {
        // Assume that all shares have the same sign; no sequence of roundings can be worse.
        self.shares.iter().map(|share| share.abs()).sum()
    }

    /// Returns a number whose shares are weighted sums of the shares of `a` and `b`.
    fn combined(value: f64, (a, times_a): (&Self, f64), (b, times_b): (&Self, f64)) -> Self {
        let mut all = Self::exact(value);
        for (to, (a, b)) in all.shares.iter_mut().zip(a.shares.iter().zip(&b.shares)) {
            *to = times_a * a + times_b * b;
        }
        all
    }

    /// Begins a new case. `loaded` contains the errors of the numbers that are loaded next.
    pub(super) fn begin(loaded: &[f64]) {
        USED.set(0);
        LOADED.with_borrow_mut(|next| {
            next.clear();
            next.extend(loaded);
        });
    }
}

impl Add for Worst {
    type Output = Self;
    fn add(self, b: Self) -> Self {
        self.plus(&b).rounded()
    }
}

impl Sub for Worst {
    type Output = Self;
    fn sub(self, b: Self) -> Self {
        self + -b
    }
}

impl Mul for Worst {
    type Output = Self;
    fn mul(self, b: Self) -> Self {
        self.times(&b).rounded()
    }
}

impl Div for Worst {
    type Output = Self;
    fn div(self, b: Self) -> Self {
        self.over(b).rounded()
    }
}

impl Neg for Worst {
    type Output = Self;
    fn neg(self) -> Self {
        Self { value: -self.value, shares: self.shares.map(|share| -share) }
    }
}

impl Lanes for Worst {
    type Scalar = f32;
    type Mask = bool;
    const N: usize = 1;

    fn splat(x: f32) -> Self {
        Self::exact(f64::from(x))
    }
    fn load(from: &[f32]) -> Self {
        let share = LOADED.with_borrow_mut(VecDeque::pop_front);
        Self::off_by(f64::from(from[0]), share.unwrap_or(0.0))
    }
    fn load_f32(from: &[f32]) -> Self {
        Self::load(from)
    }
    fn store(self, to: &mut [f32]) {
        to[0] = self.value as f32;
    }
    fn store_f32(self, to: &mut [f32]) {
        self.store(to);
    }
    fn mul_add(self, b: Self, c: Self) -> Self {
        // Round twice, as on a CPU without fused operations, where the bounds must hold as well.
        self * b + c
    }
    fn mul_error(self, _: Self, _: Self) -> Self {
        unreachable!("this level never splits an f32 into halves")
    }
    fn max(self, other: Self) -> Self {
        if self.value > other.value { self } else { other }
    }
    fn min(self, other: Self) -> Self {
        if self.value < other.value { self } else { other }
    }
    fn abs(self) -> Self {
        self.flip(self)
    }
    fn power(self) -> Self {
        // The power of two is read from the exponent bits, so it has no error.
        Self::exact(self.value.log2().floor().exp2())
    }
    fn flip(self, of: Self) -> Self {
        if of.value.is_sign_negative() { -self } else { self }
    }
    fn or_sign(self, other: Self) -> Self {
        if other.value.is_sign_negative() { -Lanes::abs(self) } else { self }
    }
    fn negative(self) -> bool {
        self.value.is_sign_negative()
    }
    fn sqrt(self) -> Self {
        let root = self.value.sqrt();
        // The derivative of the square root converts the shares of the argument to shares of the
        // root.
        Self::combined(root, (&self, 0.5 / root), (&self, 0.0)).rounded()
    }
    fn lt(self, other: Self) -> bool {
        self.value < other.value
    }
    fn le(self, other: Self) -> bool {
        self.value <= other.value
    }
    fn select(mask: bool, yes: Self, no: Self) -> Self {
        if mask { yes } else { no }
    }
}

/// A SIMD level whose f32 lanes are [`Worst`] numbers. Its f64 lanes hold ordinary f64 values.
#[derive(Clone, Copy)]
pub(super) struct Worsts;

impl Simd for Worsts {
    type F32x4 = Worst;
    type F32x8 = Worst;
    type F32x16 = Worst;
    type F64x4 = f64;
    type F64x8 = f64;
    type I64x8 = NoInts;
    type WideInts = NoInts;
    type F32s = Worst;
    type F64s = f64;
    const LEVEL: Level = Level::PORTABLE;
}

/// A stand-in for integer lanes. The filter's code does not use integer lanes.
#[derive(Clone, Copy)]
pub(super) struct NoInts;

impl Add for NoInts {
    type Output = Self;
    fn add(self, _: Self) -> Self {
        self
    }
}

impl Sub for NoInts {
    type Output = Self;
    fn sub(self, _: Self) -> Self {
        self
    }
}

impl Ints for NoInts {
    const N: usize = 1;
    const BITS: u32 = 64;

    fn splat(_: i64) -> Self {
        Self
    }
    fn load(_: &[i64]) -> Self {
        Self
    }
    fn shifted(_: &[i64], _: &[i64]) -> Self {
        Self
    }
    fn times(self, _: Self) -> Self {
        self
    }
    fn negative(self) -> u32 {
        0
    }
    fn zero(self) -> u32 {
        0
    }
}

/// A hill-climbing search for the inputs whose error comes closest to its bound. It changes numbers
/// in small or large steps and keeps every change that does not reduce the share.
pub(super) struct Search(u64);

impl Search {
    pub(super) fn new(seed: u64) -> Self {
        Self(seed)
    }

    /// Returns a random number between -1 and 1.
    pub(super) fn number(&mut self) -> f64 {
        // This is a linear congruential generator with Knuth's constants for MMIX. Its low bits
        // have short periods, so a xor and a multiplication mix in the high bits before the top 53
        // are used.
        self.0 = self.0.wrapping_mul(0x5851_f42d_4c95_7f2d).wrapping_add(0x1405_7b7e_f767_814f);
        let mixed = (self.0 ^ self.0 >> 31).wrapping_mul(0x9e37_79b9_7f4a_7c15);
        (mixed >> 11) as f64 / (1_u64 << 52) as f64 - 1.0
    }

    /// Returns a random index below `n`.
    pub(super) fn below(&mut self, n: usize) -> usize {
        ((self.number() + 1.0) * 0.5 * n as f64) as usize % n
    }

    /// Returns the largest value of `share` found in several climbs of several steps each. Every
    /// climb starts from a different input.
    pub(super) fn most<const N: usize>(
        &mut self,
        [climbs, steps]: [usize; 2],
        start: impl Fn(&mut Self) -> [f64; N],
        share: impl Fn(&[f64; N]) -> Option<f64>,
    ) -> f64 {
        let mut most = 0.0_f64;
        for _ in 0..climbs {
            // Start each climb from a different input, so that one local maximum does not end the
            // search.
            let mut best = start(self);
            let Some(mut used) = share(&best) else { continue };
            for _ in 0..steps {
                let mut next = best;
                // Use step sizes between 1 and 1e-4: large steps leave a hill, and small steps
                // reach its top.
                let size = 10.0_f64.powf(-4.0 * (self.number() + 1.0) * 0.5);
                for _ in 0..=self.below(3) {
                    let number = &mut next[self.below(N)];
                    *number += size * self.number();
                    // Occasionally set a number to exactly 0, which random steps never reach:
                    // products vanish there, and bounds are tightest.
                    if self.below(8) == 0 {
                        *number = 0.0;
                    }
                }
                if let Some(now) = share(&next).filter(|now| *now >= used) {
                    (best, used) = (next, now);
                }
            }
            most = most.max(used);
        }
        most
    }
}
