//! The filter's verdict on each lane.

use crate::simd::Lanes;

/// The number of tests, and how many of them the f32 bound left undecided.
///
/// ```
/// let mut all = intertri::Counts { tests: 64, undecided: 1 };
/// all += intertri::Counts { tests: 36, undecided: 0 };
/// assert_eq!((all.tests, all.undecided), (100, 1));
/// ```
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Counts {
    /// Tests of one ray against one triangle, not counting dead lanes.
    pub tests: u64,
    /// Tests that a resolver had to settle.
    pub undecided: u64,
}

impl core::ops::AddAssign for Counts {
    fn add_assign(&mut self, more: Self) {
        self.tests += more.tests;
        self.undecided += more.undecided;
    }
}

/// A verdict on each lane. A lane that is in neither `hit` nor `undecided` is a miss.
#[derive(Clone, Copy)]
pub(crate) struct Verdicts<F> {
    /// Hits whose t may still be beyond the far end of the interval.
    pub(crate) hit: u32,
    /// Pairs that the resolver must settle.
    pub(crate) undecided: u32,
    /// The lanes of [`Verdicts::hit`] in which the ray crosses the plane in the direction of the
    /// normal.
    pub(crate) leaves: u32,
    /// The lower bound on the mode's t, in the lanes of [`Verdicts::hit`].
    pub(crate) t_lo: F,
    /// The upper bound on the mode's t, in the lanes of [`Verdicts::hit`].
    pub(crate) t_hi: F,
}

impl<F: Lanes<Scalar = f32>> Verdicts<F> {
    /// Returns the verdict that all lanes miss.
    #[inline(always)]
    pub(crate) fn miss() -> Self {
        let zero = F::splat(0.0);
        Self { hit: 0, undecided: 0, leaves: 0, t_lo: zero, t_hi: zero }
    }
}

impl<F> Verdicts<F> {
    /// Returns the lanes that are or may be hits.
    #[inline(always)]
    pub(crate) fn lanes(&self) -> u32 {
        self.hit | self.undecided
    }

    /// Turns all lanes except the given ones into misses.
    #[inline(always)]
    pub(crate) fn keep(&mut self, lanes: u32) {
        self.hit &= lanes;
        self.undecided &= lanes;
        self.leaves &= lanes;
    }
}
