//! Fixed-width integers with exact operations. With the widths that `docs/numerics/exact.md`
//! derives, no operation overflows.

use core::cmp::Ordering;

/// Operations with more limbs than this are calls of functions that are compiled once. The compiler
/// would unroll their loops in every caller, which would take much of the compile time.
const INLINE: usize = 8;

/// An integer of N 64-bit limbs in two's complement, with the lowest limb first.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Int<const N: usize>(pub(super) [u64; N]);

impl<const N: usize> Int<N> {
    /// Creates an integer from a signed mantissa of up to 63 bits, times `2^shift`.
    #[inline(always)]
    pub(super) fn new(mantissa: i64, shift: u32) -> Self {
        if N == 1 {
            return Self([(mantissa << shift) as u64; N]);
        }
        // The magnitude of a mantissa that is shifted by less than 64 places covers at most two
        // limbs. The sign is applied last.
        let (limb, shift) = (shift as usize / 64, shift % 64);
        let mut limbs = [0; N];
        let size = u128::from(mantissa.unsigned_abs()) << shift;
        limbs[limb] = size as u64;
        if let Some(next) = limbs.get_mut(limb + 1) {
            *next = (size >> 64) as u64;
        }
        if mantissa < 0 { Self([0; N]) - Self(limbs) } else { Self(limbs) }
    }

    #[inline(always)]
    fn is_negative(&self) -> bool {
        self.0[N - 1] >> 63 != 0
    }

    /// Returns how the integer compares with 0.
    #[inline(always)]
    pub(super) fn sign(&self) -> Ordering {
        if self.is_negative() {
            return Ordering::Less;
        }
        let any = self.0.iter().fold(0, |any, limb| any | limb);
        any.cmp(&0)
    }

    /// Returns the limbs of the magnitude.
    #[inline(always)]
    pub(super) fn size(&self) -> [u64; N] {
        self.negated_if(self.is_negative()).0
    }

    #[inline(always)]
    fn negated_if(&self, is: bool) -> Self {
        if !is {
            return *self;
        }
        if N <= INLINE {
            return Self([0; N]) - *self;
        }
        let mut negated = *self;
        negate_wide(&mut negated.0);
        negated
    }

    /// Returns the same number with more limbs. The number must be non-negative.
    #[inline(always)]
    pub(super) fn widened<const M: usize>(&self) -> Int<M> {
        const { assert!(M >= N) };
        let mut limbs = [0; M];
        limbs[..N].copy_from_slice(&self.0);
        Int(limbs)
    }

    /// Returns the product, with as many limbs as both factors together.
    #[inline]
    pub(super) fn times<const M: usize, const R: usize>(&self, b: &Int<M>) -> Int<R> {
        const { assert!(R == N + M) };
        let mut product = [0; R];
        if N == 1 && M == 1 {
            // The CPU multiplies single limbs directly.
            let both = i128::from(self.0[0] as i64) * i128::from(b.0[0] as i64);
            (product[0], product[1]) = (both as u64, (both >> 64) as u64);
            return Int(product);
        }
        if R > INLINE {
            // Multiply the magnitudes, because they have more limbs of 0, which need no time.
            multiply_wide(&self.size(), &b.size(), &mut product);
            return Int(product).negated_if(self.is_negative() != b.is_negative());
        }
        multiply(&self.0, &b.0, &mut product);

        // Read as unsigned, the limbs of a negative factor with L limbs represent its value plus
        // 2^(64 L).
        let mut product = Int(product);
        product.take(b, N, self.is_negative());
        product.take(self, M, b.is_negative());
        product
    }

    /// Subtracts a number, starting at limb `from`, if `is` is true.
    #[inline(always)]
    fn take<const M: usize>(&mut self, b: &Int<M>, from: usize, is: bool) {
        // Use a mask instead of a branch, because the signs of volumes near 0 are unpredictable.
        let mask = if is { u64::MAX } else { 0 };
        if M > INLINE {
            subtract_wide(&mut self.0[from..], &b.0, mask);
        } else {
            subtract(&mut self.0[from..], &b.0, mask);
        }
    }
}

impl<const N: usize> core::ops::Add for Int<N> {
    type Output = Self;
    #[inline(always)]
    fn add(mut self, b: Self) -> Self {
        if N > INLINE {
            add_wide(&mut self.0, &b.0);
        } else {
            add(&mut self.0, &b.0);
        }
        self
    }
}

impl<const N: usize> core::ops::Sub for Int<N> {
    type Output = Self;
    #[inline(always)]
    fn sub(mut self, b: Self) -> Self {
        if N > INLINE {
            subtract_wide(&mut self.0, &b.0, u64::MAX);
        } else {
            subtract(&mut self.0, &b.0, u64::MAX);
        }
        self
    }
}

impl<const N: usize> Ord for Int<N> {
    #[inline(always)]
    fn cmp(&self, b: &Self) -> Ordering {
        // Negative numbers come first. If the signs are equal, the limbs determine the order,
        // starting with the highest.
        b.is_negative()
            .cmp(&self.is_negative())
            .then_with(|| self.0.iter().rev().cmp(b.0.iter().rev()))
    }
}

impl<const N: usize> PartialOrd for Int<N> {
    #[inline(always)]
    fn partial_cmp(&self, b: &Self) -> Option<Ordering> {
        Some(self.cmp(b))
    }
}

/// Multiplies two unsigned integers. The product has as many limbs as both factors together, all of
/// which must be 0 before.
#[inline(always)]
fn multiply(a: &[u64], b: &[u64], product: &mut [u64]) {
    for (i, a) in a.iter().enumerate() {
        let mut carry = 0;
        for (j, b) in b.iter().enumerate() {
            // (2^64 - 1)² + 2 (2^64 - 1) = 2^128 - 1: the product, the limb and the carry just fit.
            let more = u128::from(product[i + j]) + u128::from(carry);
            let sum = u128::from(*a) * u128::from(*b) + more;
            product[i + j] = sum as u64;
            carry = (sum >> 64) as u64;
        }
        product[i + b.len()] = carry;
    }
}

/// Adds b to a, which has as many limbs.
#[inline(always)]
fn add(a: &mut [u64], b: &[u64]) {
    let mut carry = false;
    for (a, b) in a.iter_mut().zip(b) {
        (*a, carry) = plus(*a, *b, carry);
    }
}

/// Subtracts `b & mask` from the lowest limbs of a.
#[inline(always)]
fn subtract(a: &mut [u64], b: &[u64], mask: u64) {
    let mut borrow = false;
    for (a, b) in a.iter_mut().zip(b) {
        (*a, borrow) = minus(*a, *b & mask, borrow);
    }
}

/// Like [`multiply`], but skips the limbs of 0 at both ends, which are most of them: a width has
/// room for coordinates from one end of the range to the other, and a number needs a few limbs.
#[inline(never)]
fn multiply_wide(a: &[u64], b: &[u64], product: &mut [u64]) {
    let ((i, a), (j, b)) = (without_zeros(a), without_zeros(b));
    multiply(a, b, &mut product[i + j..]);
}

/// Returns the limbs without the zeros at both ends, and the index of the first.
fn without_zeros(limbs: &[u64]) -> (usize, &[u64]) {
    let end = limbs.iter().rposition(|limb| *limb != 0).map_or(0, |last| last + 1);
    let start = limbs[..end].iter().position(|limb| *limb != 0).unwrap_or(0);
    (start, &limbs[start..end])
}

#[inline(never)]
fn add_wide(a: &mut [u64], b: &[u64]) {
    add(a, b);
}

#[inline(never)]
fn subtract_wide(a: &mut [u64], b: &[u64], mask: u64) {
    subtract(a, b, mask);
}

/// Negates a number in two's complement.
#[inline(never)]
fn negate_wide(limbs: &mut [u64]) {
    // The carry of `!x + 1` goes up to the lowest limb that is not 0.
    if let Some(first) = limbs.iter().position(|limb| *limb != 0) {
        limbs[first] = limbs[first].wrapping_neg();
        for limb in &mut limbs[first + 1..] {
            *limb = !*limb;
        }
    }
}

/// Returns the sum of two limbs and a carry, and the resulting carry.
#[inline(always)]
pub(super) fn plus(a: u64, b: u64, carry: bool) -> (u64, bool) {
    let (sum, over) = a.overflowing_add(b);
    let (sum, again) = sum.overflowing_add(carry.into());
    (sum, over | again)
}

/// Returns the difference of two limbs and a borrow, and the resulting borrow.
#[inline(always)]
pub(super) fn minus(a: u64, b: u64, borrow: bool) -> (u64, bool) {
    let (rest, under) = a.overflowing_sub(b);
    let (rest, again) = rest.overflowing_sub(borrow.into());
    (rest, under | again)
}

/// Returns the difference of two vectors.
#[inline(always)]
pub(super) fn difference<const N: usize>(a: &[Int<N>; 3], b: &[Int<N>; 3]) -> [Int<N>; 3] {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

/// Returns the dot product of two vectors.
#[inline(always)]
pub(super) fn dot<const N: usize, const M: usize, const R: usize>(
    a: &[Int<N>; 3],
    b: &[Int<M>; 3],
) -> Int<R> {
    a[0].times(&b[0]) + a[1].times(&b[1]) + a[2].times(&b[2])
}

/// Returns the cross product of two vectors.
#[inline(always)]
pub(super) fn cross<const N: usize, const R: usize>(
    a: &[Int<N>; 3],
    b: &[Int<N>; 3],
) -> [Int<R>; 3] {
    [
        a[1].times(&b[2]) - a[2].times(&b[1]),
        a[2].times(&b[0]) - a[0].times(&b[2]),
        a[0].times(&b[1]) - a[1].times(&b[0]),
    ]
}

#[cfg(test)]
mod tests {
    use super::{Int, multiply};

    /// Computes a product limb by limb, without negating a factor.
    fn product(a: &Int<6>, b: &Int<6>) -> Int<12> {
        let mut limbs = [0; 12];
        multiply(&a.0, &b.0, &mut limbs);
        let mut product = Int(limbs);
        product.take(b, 6, a.is_negative());
        product.take(a, 6, b.is_negative());
        product
    }

    #[test]
    fn wide_products_are_those_limb_by_limb() {
        let one_limb = |at: usize, limb: u64| {
            let mut limbs = [0; 6];
            limbs[at] = limb;
            Int(limbs)
        };
        let mut numbers = vec![Int([0; 6]), Int([0, 5, 0, 0, 7, 0]), Int([u64::MAX - 1; 6])];
        for at in 0..6 {
            numbers.extend([1, 3, 1 << 63, u64::MAX].map(|limb| one_limb(at, limb)));
        }
        // The most negative number is its own negation.
        let negated: Vec<_> = numbers.iter().map(|x| Int([0; 6]) - *x).collect();
        numbers.extend(negated);
        for a in &numbers {
            for b in &numbers {
                assert_eq!(a.times::<6, 12>(b), product(a, b), "{a:?} {b:?}");
            }
        }
    }
}
