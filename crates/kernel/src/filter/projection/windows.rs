//! Windows: rectangles on the projection.

use crate::simd::Lanes;

/// Rectangles on the projection, one per lane.
///
/// ```
/// use intertri::internal::Windows;
/// // From (0, 0) to (0.5, 0.25). N lanes hold N windows.
/// let window = Windows::<f32>::new([0.0, 0.0], [0.5, 0.25]);
/// ```
#[derive(Clone, Copy, Debug)]
pub struct Windows<F> {
    lo: [F; 2],
    hi: [F; 2],
    middle: [F; 2],
    half: [F; 2],
}

impl<F: Lanes<Scalar = f32>> Windows<F> {
    /// Creates windows from their smallest and largest x and y.
    #[inline(always)]
    pub fn new(lo: [F; 2], hi: [F; 2]) -> Self {
        let half = F::splat(0.5);
        Self {
            lo,
            hi,
            middle: [(lo[0] + hi[0]) * half, (lo[1] + hi[1]) * half],
            half: [(hi[0] - lo[0]) * half, (hi[1] - lo[1]) * half],
        }
    }

    /// Returns the minimum and maximum of a linear form in each window.
    #[inline(always)]
    pub(super) fn range(&self, form: [F; 3]) -> (F, F) {
        let [one, x, y] = form;
        // A linear form has its minimum and maximum at corners of the window: its value at the
        // centre minus or plus half of its range.
        let middle = y.mul_add(self.middle[1], x.mul_add(self.middle[0], one));
        let reach = y.abs().mul_add(self.half[1], x.abs() * self.half[0]);
        (middle - reach, middle + reach)
    }

    /// Finds which windows an outline with the extent `lo..=hi` reaches.
    #[inline(always)]
    pub(super) fn reached(&self, lo: [F; 2], hi: [F; 2]) -> F::Mask {
        self.lo[0].le(hi[0]) & lo[0].le(self.hi[0]) & self.lo[1].le(hi[1]) & lo[1].le(self.hi[1])
    }
}
