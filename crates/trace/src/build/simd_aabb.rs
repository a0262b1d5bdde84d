//! An axis-aligned bounding box in one row of eight lanes.
//!
//! ```text
//!   -lo.x  -lo.y  -lo.z  word   hi.x  hi.y  hi.z  word
//! ```
//!
//! Because the lower sides are negated, the union of two boxes is a single maximum, and the size of
//! a box is the sum of its two halves. The two remaining lanes hold words, which the box operations
//! do not use and `join` does not preserve.

use crate::tree::Aabb;
use bytemuck::Zeroable;
use intertri::simd::{Lanes, Simd};

/// The six sides of a box, and two words.
#[derive(Clone, Copy, Debug, Zeroable)]
#[repr(transparent)]
pub(super) struct SimdAabb(pub [f32; 8]);

impl SimdAabb {
    /// The empty box. Its union with another box is the other box.
    pub(super) const EMPTY: Self = Self([f32::NEG_INFINITY; 8]);

    pub(super) fn of(Aabb { lo, hi }: &Aabb) -> Self {
        Self([-lo[0], -lo[1], -lo[2], 0.0, hi[0], hi[1], hi[2], 0.0])
    }

    pub(super) fn bounds(&self) -> Aabb {
        let [x, y, z, _, hi @ ..] = self.0;
        Aabb { lo: [-x, -y, -z, 0.0], hi: [hi[0], hi[1], hi[2], 0.0] }
    }

    /// Returns the first or second word.
    #[inline(always)]
    pub(super) fn word(&self, which: usize) -> u32 {
        self.0[4 * which + 3].to_bits()
    }

    #[inline(always)]
    pub(super) fn set_word(&mut self, which: usize, word: u32) {
        self.0[4 * which + 3] = f32::from_bits(word);
    }

    /// Extends this box to contain the other box. If this function is inlined at a SIMD level with
    /// eight lanes, it compiles to one instruction.
    #[inline(always)]
    pub(super) fn join(&mut self, other: &Self) {
        for (a, b) in self.0.iter_mut().zip(&other.0) {
            // A comparison compiles to `maxps`; `f32::max` would add instructions for NaN, which
            // does not occur.
            *a = if *a > *b { *a } else { *b };
        }
    }

    /// Returns the lengths along the axes, in units of `1 / scale`. The last lane is meaningless.
    #[inline(always)]
    pub(super) fn size<S: Simd>(&self, scale: S::F32x4) -> S::F32x4 {
        // hi - lo, because the lower sides are stored negated. Scale first, because the difference
        // might overflow.
        S::F32x4::load(&self.0[4..]) * scale + S::F32x4::load(&self.0) * scale
    }

    /// Returns twice the centre, in units of `1 / scale`.
    #[inline(always)]
    pub(super) fn centre<S: Simd>(&self, scale: S::F32x4) -> S::F32x4 {
        // hi + lo, because the lower sides are stored negated.
        S::F32x4::load(&self.0[4..]) * scale - S::F32x4::load(&self.0) * scale
    }

    /// Returns one coordinate of [`SimdAabb::centre`], computed with the same operations.
    #[inline(always)]
    pub(super) fn centre_along(&self, axis: usize, scale: f32) -> f32 {
        self.0[axis % 4 + 4] * scale - self.0[axis % 4] * scale
    }
}

/// The box around centres, in the units of [`SimdAabb::centre`].
#[derive(Clone, Copy, Debug)]
pub(super) struct Centres {
    pub(super) lo: [f32; 4],
    pub(super) hi: [f32; 4],
}

impl Centres {
    pub(super) fn join(self, other: Self) -> Self {
        let mut both = self;
        for k in 0..4 {
            both.lo[k] = both.lo[k].min(other.lo[k]);
            both.hi[k] = both.hi[k].max(other.hi[k]);
        }
        both
    }
}

/// [`Centres`] in lanes.
pub(super) struct CentreLanes<F> {
    lo: F,
    hi: F,
}

impl<F: Lanes<Scalar = f32>> CentreLanes<F> {
    #[inline(always)]
    pub(super) fn none() -> Self {
        Self { lo: F::splat(f32::INFINITY), hi: F::splat(f32::NEG_INFINITY) }
    }

    /// Extends the box to contain a centre, in the lanes that the mask selects.
    #[inline(always)]
    pub(super) fn reach(&mut self, centre: F, which: F::Mask) {
        self.lo = F::select(which, self.lo.min(centre), self.lo);
        self.hi = F::select(which, self.hi.max(centre), self.hi);
    }

    #[inline(always)]
    pub(super) fn store(self) -> Centres {
        let mut centres = Centres { lo: [0.0; 4], hi: [0.0; 4] };
        self.lo.store(&mut centres.lo);
        self.hi.store(&mut centres.hi);
        centres
    }
}
