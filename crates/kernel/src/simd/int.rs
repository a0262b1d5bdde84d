//! Lanes of i64 integers, for intersection tests without rounding.

use core::ops::{Add, Sub};

use super::pair::Pair;

/// N i64 integers in lanes. `+` and `-` wrap, as they do on the CPU, so make sure that results do
/// not overflow.
///
/// A mask is a plain integer here: bit i stands for lane i.
///
/// ```
/// use intertri::simd::{Ints, Simd, WithSimd, dispatch};
///
/// /// Computes `3 x - 2^40` and the lanes in which a result is negative or 0.
/// struct Line([i64; 4]);
/// impl WithSimd for Line {
///     type Output = ([i64; 4], u32, u32);
///     #[inline(always)]
///     fn run<S: Simd>(self) -> Self::Output {
///         let x = S::I64x4::load(&self.0);
///         let three = S::I64x4::load_f32(&[3.0; 4]);
///         let (million, none) = (S::I64x4::splat(1 << 20), S::I64x4::splat(0));
///         assert_eq!((three.times(x) - three.mul_narrow(x)).zero(), 0b1111);
///         let y = three.mul_narrow(x) - S::I64x4::dot([million, none, none], [million; 3]);
///         let mut lanes = [0; 4];
///         (y + S::I64x4::splat(0)).store(&mut lanes);
///         (lanes, y.negative(), (y - y).zero())
///     }
/// }
/// let (lanes, negative, zero) = dispatch(Line([0, 1, -7, 9]));
/// assert_eq!(lanes, [0, 3, -21, 27].map(|x: i64| x - (1 << 40)));
/// assert_eq!((negative, zero, 4), (0b1111, 0b1111, lanes.len()));
/// ```
pub trait Ints: Copy + Add<Output = Self> + Sub<Output = Self> {
    /// The number of lanes.
    const N: usize;

    /// Copies a value to every lane.
    fn splat(x: i64) -> Self;
    /// Loads the first N integers of a slice.
    ///
    /// # Panics
    /// Panics if the slice is shorter than N.
    fn load(from: &[i64]) -> Self;
    /// Loads the first N elements of a slice. They must be integers that fit in i32.
    ///
    /// # Panics
    /// Panics if the slice is shorter than N.
    fn load_f32(from: &[f32]) -> Self;
    /// Writes the lanes to the first N elements of a slice.
    ///
    /// # Panics
    /// Panics if the slice is shorter than N.
    fn store(self, to: &mut [i64]);

    /// Returns the exact product of lanes that fit in i32.
    fn mul_narrow(self, b: Self) -> Self;
    /// Returns the lower 64 bits of the product.
    fn times(self, b: Self) -> Self;
    /// Returns the dot product of `a`, whose components must fit in i32, and an arbitrary `b`. The
    /// result is exact if it fits in i64, even if intermediate results wrap.
    fn dot(a: [Self; 3], b: [Self; 3]) -> Self;

    /// Returns the lanes that are negative.
    fn negative(self) -> u32;
    /// Returns the lanes that are 0.
    fn zero(self) -> u32;

    /// Returns [`Ints::negative`] for `self` in the low bits and for `last` in the bits above.
    /// Computes both at once where that is faster.
    #[doc(hidden)]
    #[inline(always)]
    fn negative_of_two(self, last: Self) -> u32 {
        self.negative() | last.negative() << Self::N
    }
    /// Returns [`Ints::zero`] for `self` in the low bits and for `last` in the bits above.
    #[doc(hidden)]
    #[inline(always)]
    fn zero_of_two(self, last: Self) -> u32 {
        self.zero() | last.zero() << Self::N
    }
}

impl<L: Ints> Ints for Pair<L> {
    const N: usize = 2 * L::N;

    #[inline(always)]
    fn splat(x: i64) -> Self {
        Self(L::splat(x), L::splat(x))
    }
    #[inline(always)]
    fn load(from: &[i64]) -> Self {
        Self(L::load(from), L::load(&from[L::N..]))
    }
    #[inline(always)]
    fn load_f32(from: &[f32]) -> Self {
        Self(L::load_f32(from), L::load_f32(&from[L::N..]))
    }
    #[inline(always)]
    fn store(self, to: &mut [i64]) {
        self.0.store(to);
        self.1.store(&mut to[L::N..]);
    }
    #[inline(always)]
    fn mul_narrow(self, b: Self) -> Self {
        Self(self.0.mul_narrow(b.0), self.1.mul_narrow(b.1))
    }
    #[inline(always)]
    fn times(self, b: Self) -> Self {
        Self(self.0.times(b.0), self.1.times(b.1))
    }
    #[inline(always)]
    fn dot([ax, ay, az]: [Self; 3], [bx, by, bz]: [Self; 3]) -> Self {
        Self(
            L::dot([ax.0, ay.0, az.0], [bx.0, by.0, bz.0]),
            L::dot([ax.1, ay.1, az.1], [bx.1, by.1, bz.1]),
        )
    }
    #[inline(always)]
    fn negative(self) -> u32 {
        self.0.negative_of_two(self.1)
    }
    #[inline(always)]
    fn zero(self) -> u32 {
        self.0.zero_of_two(self.1)
    }
}

/// A single i64 whose `+` and `-` wrap in every build.
#[derive(Clone, Copy)]
pub(crate) struct WrappingI64(i64);

impl Add for WrappingI64 {
    type Output = Self;
    #[inline(always)]
    fn add(self, b: Self) -> Self {
        Self(self.0.wrapping_add(b.0))
    }
}

impl Sub for WrappingI64 {
    type Output = Self;
    #[inline(always)]
    fn sub(self, b: Self) -> Self {
        Self(self.0.wrapping_sub(b.0))
    }
}

impl Ints for WrappingI64 {
    const N: usize = 1;

    #[inline(always)]
    fn splat(x: i64) -> Self {
        Self(x)
    }
    #[inline(always)]
    fn load(from: &[i64]) -> Self {
        Self(from[0])
    }
    #[inline(always)]
    fn load_f32(from: &[f32]) -> Self {
        Self(from[0] as i64)
    }
    #[inline(always)]
    fn store(self, to: &mut [i64]) {
        to[0] = self.0;
    }
    #[inline(always)]
    fn mul_narrow(self, b: Self) -> Self {
        self.times(b)
    }
    #[inline(always)]
    fn times(self, b: Self) -> Self {
        Self(self.0.wrapping_mul(b.0))
    }
    #[inline(always)]
    fn dot(a: [Self; 3], b: [Self; 3]) -> Self {
        // Wrapping is arithmetic modulo 2^64: if the sum fits, it is correct even if intermediate
        // results overflow.
        a[0].mul_narrow(b[0]) + a[1].mul_narrow(b[1]) + a[2].mul_narrow(b[2])
    }
    #[inline(always)]
    fn negative(self) -> u32 {
        (self.0 < 0) as u32
    }
    #[inline(always)]
    fn zero(self) -> u32 {
        (self.0 == 0) as u32
    }
}

/// Implements integer lanes for the vectors of `wide`.
macro_rules! wide {
    ($t:ident, $n:literal) => {
        impl Ints for ::wide::$t {
            const N: usize = $n;

            #[inline(always)]
            fn splat(x: i64) -> Self {
                Self::new([x; $n])
            }
            #[inline(always)]
            fn load(from: &[i64]) -> Self {
                Self::new(from[..$n].try_into().expect("the slice has N elements"))
            }
            #[inline(always)]
            fn load_f32(from: &[f32]) -> Self {
                let from: [f32; $n] = from[..$n].try_into().expect("the slice has N elements");
                Self::new(from.map(|x| i64::from(x as i32)))
            }
            #[inline(always)]
            fn store(self, to: &mut [i64]) {
                to[..$n].copy_from_slice(&self.to_array());
            }
            #[inline(always)]
            fn mul_narrow(self, b: Self) -> Self {
                self * b
            }
            #[inline(always)]
            fn times(self, b: Self) -> Self {
                self * b
            }
            #[inline(always)]
            fn dot(a: [Self; 3], b: [Self; 3]) -> Self {
                a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
            }
            #[inline(always)]
            fn negative(self) -> u32 {
                self.to_bitmask()
            }
            #[inline(always)]
            fn zero(self) -> u32 {
                self.simd_eq(Self::new([0; $n])).to_bitmask()
            }
        }
    };
}
wide!(i64x4, 4);
wide!(i64x8, 8);
